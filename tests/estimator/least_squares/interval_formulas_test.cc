// Intervals recomputed: percentile-t from refits of one's own, degrees of freedom from dense quadratic forms, what held
// parameters and redrawn data may do, by closed forms.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/intervals/bootstrap.h"
#include "estimator/intervals/profile.h"
#include "estimator/intervals/redraw.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/held_influence.h"
#include "estimator/least_squares/refit.h"
#include "estimator/least_squares/sandwich.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/noise_experiment.h"

namespace sagitta::interval_formulas_test {
namespace {

// One sided errors that whole configurations share: t is skewed, and which end is which shows.
CalibrationProblem SkewedConfigurations() {
  test::Kr270Design design;
  design.configurations = 90;
  design.stations = 1;
  CalibrationProblem problem = test::Kr270Problem(design, test::Kr270Truth(), 6);
  test::RandomNumbers random(11);
  for (const Shot& shot : problem.data().shots) {
    const double rare = -std::log(random.Uniform(1e-9, 1.0));
    for (const int k : shot.observations) {
      problem.mutable_data()->observations[k].point_in_station +=
          Vector3<double>(1.0, -0.6, 0.8) * (1.5e-4 * rare * rare);
    }
  }
  return problem;
}

// (n + 1) p of the sorted, linear between.
double Quantile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  const double at = (static_cast<double>(values.size()) + 1.0) * p - 1.0;
  const auto below = static_cast<size_t>(at);
  return values[below] + (at - static_cast<double>(below)) * (values[below + 1] - values[below]);
}

// Plain cluster-robust standard deviations: roots of (J'WJ)^-1 (sum w_g^2 s_g s_g') (J'WJ)^-1 / .. with s_g of a
// configuration once; drawn w times it is in the data w times, each with its score.
Eigen::VectorXd ClusterSigmas(const CalibrationProblem& problem, const ParameterSet& at,
                              const std::vector<int>& estimated, const std::vector<double>& weights) {
  const std::vector<int> rows = problem.CalibrationObservations();
  const Linearization fit = Linearize(problem, at, rows, estimated, ObservationNoise(problem, rows, 1e-3));
  const auto n = static_cast<long>(estimated.size());
  const Eigen::VectorXd scale = fit.jacobian.colwise().norm();
  const Eigen::MatrixXd j = fit.jacobian * scale.cwiseInverse().asDiagonal();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n), middle = normal;
  for (size_t first = 0; first < rows.size(); first += 3) {  // the three markers of a configuration
    const double w = weights.empty() ? 1.0 : weights[first];
    const Eigen::MatrixXd own = j.middleRows(3 * static_cast<long>(first), 9);
    const Eigen::VectorXd score = own.transpose() * fit.residual.segment(3 * static_cast<long>(first), 9);
    normal += w * own.transpose() * own;
    middle += w * score * score.transpose();
  }
  const Eigen::MatrixXd inverse = normal.inverse();
  return (inverse * middle * inverse).diagonal().cwiseSqrt().cwiseQuotient(scale);
}

TEST(IntervalFormulas, PercentileTOfDrawnConfigurations) {
  const CalibrationProblem problem = SkewedConfigurations();
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  Estimate drawn = estimate;
  BootstrapOptions options;
  options.kind = BootstrapKind::kConfigurations;
  options.replicates = 199;
  options.num_threads = 2;
  BootstrapIntervals(problem, options, &drawn);
  ASSERT_EQ(drawn.intervals.replicates, 199);
  std::vector<std::vector<double>> t(estimate.estimated.size());
  for (std::uint64_t i = 0; i < 199; ++i) {
    std::mt19937_64 random(SeedOf(options.seed, 2 * i));
    std::vector<double> count(90, 0.0), weights;
    for (int k = 0; k < 90; ++k) count[random() % 90] += 1.0;
    for (int k = 0; k < 270; ++k) weights.push_back(count[k / 3]);
    RefitOptions refit_options;
    refit_options.weights = weights;
    const Refit refit = RefitFrom(problem, estimate.parameters, refit_options);
    ASSERT_TRUE(refit.converged);
    const Eigen::VectorXd shift = TangentDifference(refit.parameters, estimate.parameters);
    const Eigen::VectorXd sigma = ClusterSigmas(problem, refit.parameters, estimate.estimated, weights);
    for (size_t c = 0; c < t.size(); ++c) t[c].push_back(shift[estimate.estimated[c]] / sigma[static_cast<long>(c)]);
  }
  const Eigen::VectorXd plain = ClusterSigmas(problem, estimate.parameters, estimate.estimated, {});
  double skew = 0.0;
  for (size_t c = 0; c < t.size(); ++c) {
    const ParameterEstimate& row = drawn.table[estimate.estimated[c]];
    const double s = plain[static_cast<long>(c)], low = Quantile(t[c], 0.025), high = Quantile(t[c], 0.975);
    EXPECT_NEAR((row.value - row.ci95.low) / (s * high), 1.0, 1e-3) << row.name;
    EXPECT_NEAR((row.ci95.high - row.value) / (-s * low), 1.0, 1e-3) << row.name;
    skew = std::max(skew, std::abs(high + low) / (high - low));
  }
  EXPECT_GT(skew, 0.1);  // the ends exchanged would be seen
}

// Student's quantile over the normal one where the noise that is drawn was itself estimated.
TEST(IntervalFormulas, TheBootstrapCountsThatTheNoiseWasEstimated) {
  const CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), test::Kr270Truth(), 5);
  const Estimate estimate = EstimateJointly(problem);
  Estimate known = estimate, estimated = estimate;
  estimated.interval_dof.setConstant(5.0);
  BootstrapOptions options;
  options.replicates = 99;
  BootstrapIntervals(problem, options, &known);
  BootstrapIntervals(problem, options, &estimated);
  for (const int i : estimate.estimated) {
    const auto width = [i](const Estimate& of) { return of.table[i].ci95.high - of.table[i].ci95.low; };
    EXPECT_NEAR(width(estimated) / width(known), 2.570582 / 1.959964, 1e-6);
  }
}

// An unstated noise of 0.1 mm is a hundred times the sigma that rows are weighed by meanwhile: ends stay at t sigma.
TEST(IntervalFormulas, ProfileAtAnEstimatedNoise) {
  test::Kr270Design design;
  design.configurations = 30;
  CalibrationProblem problem = test::Kr270Problem(design, test::Kr270Truth(), 3);
  for (Observation& row : problem.mutable_data()->observations) row.sigma.setZero();
  const Estimate estimate = EstimateJointly(problem);
  Estimate profiled = estimate;
  ProfileOptions options;
  options.num_threads = 2;
  ProfileIntervals(problem, options, &profiled);
  ASSERT_EQ(profiled.intervals.method, CovarianceKind::kProfile);
  for (const int i : estimate.estimated) {
    const ParameterEstimate& ellipse = estimate.table[i];
    const ParameterEstimate& row = profiled.table[i];
    EXPECT_NEAR((row.ci95.high - row.value) / (ellipse.ci95.high - ellipse.value), 1.0, 0.02) << row.name;
    EXPECT_NEAR((row.value - row.ci95.low) / (ellipse.value - ellipse.ci95.low), 1.0, 0.02) << row.name;
  }
}

// nu = tr(Q)^2 / tr(Q^2), Q = (I - H) B (I - H), B = blockdiag(a_g a_g'), a_g = (I - H_gg)^-1/2 J_g (J'J)^-1 e_c: the
// variance as a quadratic form in independent errors, dense.
TEST(IntervalFormulas, DegreesOfFreedomOfTheSandwich) {
  test::RandomNumbers random(5);
  constexpr int kObservations = 10, kColumns = 4;
  Linearization fit;
  fit.jacobian.resize(3 * kObservations, kColumns);
  fit.residual.resize(3 * kObservations);
  for (long i = 0; i < fit.jacobian.size(); ++i) fit.jacobian.data()[i] = random.Uniform(-1.0, 1.0);
  fit.jacobian.topRows(6) *= 3.0;  // one cluster with a large leverage
  for (double& r : fit.residual) r = random.Uniform(-1.0, 1.0);
  std::vector<int> clusters;
  for (int c = 0; c < kColumns; ++c) fit.columns.push_back(c);
  for (int k = 0; k < kObservations; ++k) {
    fit.observations.push_back(k);
    clusters.push_back(k / 2);
  }
  const Eigen::MatrixXd& j = fit.jacobian;
  const Eigen::MatrixXd inverse = (j.transpose() * j).inverse();
  const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(j.rows(), j.rows()) - j * inverse * j.transpose();
  fit.residual = (left * fit.residual).eval();
  const RobustCovariance robust = SandwichCovariance(fit, clusters);
  for (int c = 0; c < kColumns; ++c) {
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(j.rows(), j.rows());
    double variance = 0.0;
    for (int g = 0; g < kObservations / 2; ++g) {
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(left.block(6 * g, 6 * g, 6, 6));
      const Eigen::VectorXd a = eigen.operatorInverseSqrt() * j.middleRows(6 * g, 6) * inverse.col(c);
      b.block(6 * g, 6 * g, 6, 6) = a * a.transpose();
      variance += std::pow(a.dot(fit.residual.segment(6 * g, 6)), 2);
    }
    const Eigen::MatrixXd q = left * b * left;
    EXPECT_NEAR(robust.covariance(c, c), variance, 1e-9 * variance);
    EXPECT_NEAR(robust.dof[c], q.trace() * q.trace() / (q * q).trace(), 1e-6 * robust.dof[c]) << c;
  }
}

// Columns (1, 1, 1) estimated and h = (1, -1, 0) held, range 1 m, residual r, noise s: G = 0, information
// 1 + 2 / s^2, pull -(h . r) / s^2 over it, second moment 1 / information + pull^2.
TEST(IntervalFormulas, WhatHeldParametersMayBe) {
  const ParameterSet parameters({"S1"}, {"M1"}, {});
  Linearization both;
  both.columns = {0, 1};
  both.observations = {0};
  both.jacobian.resize(3, 2);
  both.jacobian << 1, 1, 1, -1, 1, 0;
  both.residual = Vector3<double>(0.3, -0.5, 0.2);
  const double s = 0.7, information = 1.0 + 2.0 / (s * s), pull = -0.8 / (s * s) / information;
  HeldInfluence held = FindHeldInfluence(both, parameters, 1, s);
  EXPECT_NEAR(held.slopes(0, 0), 0.0, 1e-15);
  EXPECT_NEAR(held.second_moment(0, 0), 1.0 / information + pull * pull, 1e-12);
  // h = (2, 0, 0.5): the estimated one absorbs the mean, -2.5 / 3 for each unit; what is left of h is h - 2.5 / 3.
  both.jacobian.col(1) = Vector3<double>(2.0, 0.0, 0.5);
  held = FindHeldInfluence(both, parameters, 1, s);
  EXPECT_NEAR(held.slopes(0, 0), -2.5 / 3.0, 1e-12);
  const Vector3<double> left = Vector3<double>(2.0, 0.0, 0.5).array() - 2.5 / 3.0;
  const double known = 1.0 + left.squaredNorm() / (s * s);
  const double off = -left.dot(both.residual.head<3>()) / (s * s) / known;
  EXPECT_NEAR(held.second_moment(0, 0), 1.0 / known + off * off, 1e-12);
  EXPECT_NEAR(AddedCovariance(held)(0, 0), 2.5 / 3.0 * 2.5 / 3.0 * held.second_moment(0, 0), 1e-12);
}

// The data of a prior are drawn as it states them: about the truth by its standard deviation.
TEST(IntervalFormulas, PriorsAreDrawnAnew) {
  ParameterSet truth({"S1"}, {"M1"}, {});
  truth.coordinate(0).prior_sigma = 2e-3;
  constexpr int kDraws = 2000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    ParameterSet drawn = truth;
    DrawPriors(truth, SeedOf(9, i), &drawn);
    EXPECT_EQ(drawn.coordinates()[1].prior_value, truth.coordinates()[1].prior_value);
    sum += drawn.coordinates()[0].prior_value;
    squares += std::pow(drawn.coordinates()[0].prior_value, 2);
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 4.5 * 2e-3 / std::sqrt(kDraws));
  EXPECT_NEAR(std::sqrt(squares / kDraws) / 2e-3, 1.0, 4.5 / std::sqrt(2.0 * kDraws));
}

// Data drawn at three times the noise: instrument and joints alike. Joints of 100 urad, next to which the instrument's
// 1 um is nothing.
TEST(IntervalFormulas, DrawnDataHaveTheScaleOfTheNoiseOnJointsToo) {
  test::RepeatDesign design;
  design.repeats = 1;
  design.tracker = 1e-6;
  Measurements data = test::RepeatRows(design);
  const test::Kr270Truth truth;
  test::MeasureRepeated(truth, design, 3, &data);
  Experiment experiment;
  experiment.repeatability.angle.common = 100e-6;
  const CalibrationProblem problem = test::Kr270ProblemOf(data, experiment);
  const Eigen::Matrix3Xd exact = PredictPoints(problem, problem.parameters, problem.CalibrationObservations());
  double squares[2] = {0.0, 0.0};
  for (const int scaled : {0, 1}) {
    const Simulator redraw = RedrawAt(problem, problem.parameters, scaled == 1 ? 3.0 : 1.0, 1e-3);
    for (int i = 0; i < 40; ++i) {
      Measurements drawn = problem.data();
      ASSERT_TRUE(redraw.Draw(SeedOf(4, i), &drawn));  // the same numbers at both scales
      for (size_t k = 0; k < drawn.observations.size(); ++k) {
        squares[scaled] += (drawn.observations[k].point_in_station - exact.col(static_cast<long>(k))).squaredNorm();
      }
    }
  }
  EXPECT_NEAR(std::sqrt(squares[1] / squares[0]), 3.0, 0.01);  // to the second order of 300 urad
}

}  // namespace
}  // namespace sagitta::interval_formulas_test
