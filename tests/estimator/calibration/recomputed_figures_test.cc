// Figures of an estimate recomputed from its residuals, with derivatives by differences and small dense algebra:
// nothing of what judged it.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/statistics/distributions.h"
#include "problems/loads.h"
#include "tests/support/constant_orientation.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/noise_experiment.h"
#include "tests/support/predicted.h"

namespace sagitta::recomputed_figures_test {
namespace {

// Student's t_0.975 by integrating its density, (1 + t^2 / n)^-(n + 1)/2, in steps of a thousandth.
double StudentByItsDensity(int dof) {
  constexpr double kStep = 1e-3;
  std::vector<double> integral = {0.0};
  const auto density = [dof](double t) { return std::pow(1.0 + t * t / dof, -0.5 * (dof + 1)); };
  for (int i = 0; i < 200000; ++i) {  // Simpson
    const double t = kStep * i;
    const double part = density(t) + 4.0 * density(t + 0.5 * kStep) + density(t + kStep);
    integral.push_back(integral.back() + kStep / 6.0 * part);
  }
  const double wanted = 0.95 * integral.back();
  const auto above = std::lower_bound(integral.begin(), integral.end(), wanted);
  const auto i = static_cast<double>(above - integral.begin());
  return kStep * (i - (*above - wanted) / (*above - *(above - 1)));
}

Vector3<double> Residual(const CalibrationProblem& problem, const Estimate& estimate, int k) {
  return problem.data().observations[k].point_in_station - estimate.predicted.col(k);
}

// d points / d coordinates by central differences, 3 n x columns, m per SI unit.
Eigen::MatrixXd Slopes(const CalibrationProblem& problem, const ParameterSet& at, const std::vector<int>& rows,
                       const std::vector<int>& coordinates) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd slopes(3 * rows.size(), coordinates.size());
  for (size_t c = 0; c < coordinates.size(); ++c) {
    Eigen::Matrix3Xd side[2];
    for (const int s : {0, 1}) {
      ParameterSet moved = at;
      moved.Plus((s == 0 ? kStep : -kStep) * Eigen::VectorXd::Unit(at.num_coordinates(), coordinates[c]));
      side[s] = PredictPoints(problem, moved, rows);
    }
    const Eigen::Matrix3Xd slope = (side[0] - side[1]) / (2.0 * kStep);
    slopes.col(static_cast<long>(c)) = Eigen::Map<const Eigen::VectorXd>(slope.data(), slope.size());
  }
  return slopes;
}

Experiment HeldOut(double fraction) {
  Experiment experiment;
  experiment.validation.kind = fraction > 0.0 ? ValidationSpec::Kind::kFraction : ValidationSpec::Kind::kNone;
  experiment.validation.fraction = fraction;
  return experiment;
}

CalibrationProblem Held(int configurations, double fraction, bool stated, double true_over_stated = 1.0) {
  test::Kr270Design design;
  design.configurations = configurations;
  const test::Kr270Truth truth;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, design.sigma * true_over_stated, 4, &data);
  for (Observation& row : data.observations) {
    if (!stated) row.sigma.setZero();
  }
  return test::Kr270ProblemOf(data, HeldOut(fraction));
}

// 39 unknowns (33 of one station's): few rows leave few degrees of freedom, where rows for dof and dof - 1 show.
TEST(RecomputedFigures, SigmaOfResidualsAndItsIntervals) {
  for (const bool stated : {true, false}) {
    for (const int configurations : {6, 7, 9}) {
      const CalibrationProblem problem = Held(configurations, 0.0, stated, stated ? 3.0 : 1.0);
      const Estimate estimate = EstimateJointly(problem);
      ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
      double squares = 0.0;
      for (size_t k = 0; k < problem.data().observations.size(); ++k) {
        squares += Residual(problem, estimate, static_cast<int>(k)).squaredNorm();
      }
      const int rows = 3 * static_cast<int>(problem.data().observations.size());
      const int dof = rows - static_cast<int>(estimate.estimated.size());
      ASSERT_EQ(estimate.dof, dof);
      const double sigma = std::sqrt(squares / dof), student = StudentByItsDensity(dof);
      if (stated) {
        EXPECT_NEAR(estimate.sigma.a_posteriori, sigma / 1e-4, 1e-9 * sigma / 1e-4);
        EXPECT_NEAR(estimate.chi2, squares / 1e-8, 1e-9 * estimate.chi2);
        EXPECT_TRUE(estimate.sigma.scaled);
      } else {
        EXPECT_NEAR(estimate.sigma.estimated, sigma, 1e-9 * sigma);
      }
      const Eigen::MatrixXd slopes =
          Slopes(problem, estimate.parameters, problem.CalibrationObservations(), estimate.estimated);
      const Eigen::VectorXd scale = slopes.colwise().norm();
      const Eigen::MatrixXd scaled = slopes * scale.cwiseInverse().asDiagonal();
      const Eigen::MatrixXd inverse = (scaled.transpose() * scaled).inverse();
      for (size_t c = 0; c < estimate.estimated.size(); ++c) {
        const ParameterEstimate& row = estimate.table[estimate.estimated[c]];
        const auto i = static_cast<long>(c);
        EXPECT_NEAR(row.sigma / (sigma * std::sqrt(inverse(i, i)) / scale[i]), 1.0, 1e-4) << row.name;
        EXPECT_NEAR((row.ci95.high - row.value) / row.sigma, student, 1e-5) << dof;
        EXPECT_NEAR((row.value - row.ci95.low) / row.sigma, student, 1e-5) << dof;
      }
    }
  }
}

TEST(RecomputedFigures, SizesOfResiduals) {
  const CalibrationProblem problem = Held(24, 0.25, true);
  const Estimate estimate = EstimateJointly(problem);
  for (const bool held_out : {false, true}) {
    double squares = 0.0, largest = 0.0, farthest = 0.0;
    const std::vector<int> rows = held_out ? problem.ValidationObservations() : problem.CalibrationObservations();
    ASSERT_EQ(rows.size(), held_out ? 18u : 54u);
    for (const int k : rows) {
      const Vector3<double> r = Residual(problem, estimate, k);
      squares += r.squaredNorm();
      largest = std::max(largest, r.cwiseAbs().maxCoeff());
      farthest = std::max(farthest, r.norm());
    }
    const ResidualSize& size = held_out ? estimate.validation : estimate.fit;
    const auto n = static_cast<double>(rows.size());
    EXPECT_NEAR(size.rms, std::sqrt(squares / (3 * n)), 1e-15);
    EXPECT_NEAR(size.distance_rms, std::sqrt(squares / n), 1e-15);
    EXPECT_NEAR(size.max, largest, 1e-15);
    EXPECT_NEAR(size.distance_max, farthest, 1e-15);
    EXPECT_GT(farthest, 1.05 * largest);
  }
}

// noise_floor^2 and predicted_rms^2: the mean over held-out coordinates of instrument, joints' deviations and
// parameters. Six configurations leave large parameters' parts; the joints' 40 urad are a third of the rest.
TEST(RecomputedFigures, WhatIsExpectedOfHeldOutPoints) {
  for (const double urad : {0.0, 40.0}) {
    test::Kr270Design design;
    design.configurations = 14;
    const test::Kr270Truth truth;
    Measurements data = test::DesignMeasurements(design);
    test::MeasureKr270(truth, design.sigma, 4, &data);
    Experiment experiment = HeldOut(0.3);
    if (urad > 0.0) experiment.repeatability.angle.common = urad * 1e-6;
    const CalibrationProblem problem = test::Kr270ProblemOf(data, experiment);
    const Estimate estimate = EstimateJointly(problem);
    ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
    ASSERT_FALSE(estimate.sigma.scaled);
    ASSERT_EQ(estimate.held.coordinates.size(), 0u);
    const std::vector<int> rows = problem.ValidationObservations();
    const Eigen::MatrixXd slopes = Slopes(problem, estimate.parameters, rows, estimate.estimated);
    double parameters = 0.0, joints = 0.0;
    for (long i = 0; i < slopes.rows(); ++i)
      parameters += slopes.row(i) * estimate.covariance * slopes.row(i).transpose();
    for (const int k : rows) {
      const Observation& row = problem.data().observations[k];
      const Eigen::VectorXd& q = problem.data().ConfigurationOf(row).q;
      const int station = problem.data().shots[row.shot].station;
      for (int j = 0; j < 6; ++j) {
        const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(6, j);
        const Vector3<double> lever = (test::ExactPoint(truth, q + step, row.marker, station) -
                                       test::ExactPoint(truth, q - step, row.marker, station)) /
                                      2e-6;
        joints += lever.squaredNorm() * urad * urad * 1e-12;
      }
    }
    const double n = 3.0 * static_cast<double>(rows.size());
    const double expected = std::sqrt(1e-8 + joints / n + parameters / n);
    EXPECT_GT(parameters / n, 1e-9);
    // The errors of the estimate turn levers by 1e-4.
    EXPECT_NEAR(estimate.noise_floor / expected, 1.0, 1e-3) << urad;
    EXPECT_NEAR(estimate.validation_predicted_rms / expected, 1.0, 1e-3) << urad;
  }
}

// A grid that never turns the flange leaves directions open; elsewhere the points may be off by them: J_h + J G of S.
TEST(RecomputedFigures, WhatIsHeldIsExpectedOfHeldOutPointsElsewhere) {
  const Eigen::Matrix3d one = test::Turn(Eigen::Vector3d::UnitY(), 0.3),
                        other = test::Turn(Eigen::Vector3d::UnitX(), 1.2);
  Measurements data = test::ConstantOrientationGrid(one, 40, 3, 5e-5);
  const Measurements elsewhere = test::ConstantOrientationGrid(other, 10, 4, 5e-5);
  for (int c = 0; c < 10; ++c) {
    Configuration configuration = elsewhere.configurations[c];
    configuration.id = "V" + std::to_string(c);
    Shot shot = elsewhere.shots[c];
    shot.configuration = 40 + c;
    shot.observations = {40 + c};
    Observation row = elsewhere.observations[c];
    row.shot = 40 + c;
    row.row = 40 + c;
    data.files[0].rows.push_back({42 + c, {}});
    data.configurations.push_back(configuration);
    data.shots.push_back(shot);
    data.observations.push_back(row);
  }
  test::MeasureKr270(test::Kr270Truth(), 5e-5, 4, &data);
  CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  for (int c = 40; c < 50; ++c) problem.mutable_data()->configurations[c].is_validation = true;
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  ASSERT_GT(estimate.held.coordinates.size(), 0u);
  const std::vector<int> rows = problem.ValidationObservations();
  const Eigen::MatrixXd slopes = Slopes(problem, estimate.parameters, rows, estimate.estimated);
  const Eigen::MatrixXd open =
      Slopes(problem, estimate.parameters, rows, estimate.held.coordinates) + slopes * estimate.held.slopes;
  double by_parameters = 0.0, by_held = 0.0;
  for (long i = 0; i < slopes.rows(); ++i) {
    by_parameters += slopes.row(i) * estimate.covariance * slopes.row(i).transpose();
    by_held += open.row(i) * estimate.held.second_moment * open.row(i).transpose();
  }
  const double n = 3.0 * static_cast<double>(rows.size());
  const double scale = estimate.sigma.scaled ? estimate.sigma.a_posteriori : 1.0;
  const double expected = std::sqrt(scale * scale * 25e-10 + (by_parameters + by_held) / n);
  EXPECT_GT(by_held / n, 1e-8);
  EXPECT_NEAR(estimate.validation_predicted_rms / expected, 1.0, 1e-3);
}

// Loaded minus the mean of the unloaded rows of equal configuration, visit, station and marker.
TEST(RecomputedFigures, Deflections) {
  const test::LoadedTruth truth;
  const test::LoadedSetup setup = test::SetupFor(truth);
  Measurements data = test::LoadedRows(test::LoadedDesign(), truth);
  test::Measure(test::ExactPoints(truth, data), 2e-5, 7, &data);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  double before = 0.0, after = 0.0, farthest = 0.0;
  int pairs = 0;
  const auto& all = problem.data().observations;
  for (size_t a = 0; a < all.size(); ++a) {
    const Shot& loaded = problem.data().shots[all[a].shot];
    if (!IsLoaded(loaded)) continue;
    Vector3<double> mean = Vector3<double>::Zero(), mean_residual = mean;
    int count = 0;
    for (size_t b = 0; b < all.size(); ++b) {
      const Shot& other = problem.data().shots[all[b].shot];
      if (IsLoaded(other) || other.configuration != loaded.configuration || other.visit != loaded.visit ||
          other.station != loaded.station || all[a].marker != all[b].marker) {
        continue;
      }
      mean += all[b].point_in_station;
      mean_residual += Residual(problem, estimate, static_cast<int>(b));
      ++count;
    }
    if (count == 0) continue;
    const Vector3<double> measured = all[a].point_in_station - mean / count;
    const Vector3<double> left = Residual(problem, estimate, static_cast<int>(a)) - mean_residual / count;
    before += measured.squaredNorm();
    after += left.squaredNorm();
    farthest = std::max(farthest, left.norm());
    ++pairs;
  }
  ASSERT_GT(pairs, 10);
  EXPECT_EQ(estimate.deflection_after.observations, pairs);
  EXPECT_NEAR(estimate.deflection_before.rms, std::sqrt(before / (3.0 * pairs)), 1e-12);
  EXPECT_NEAR(estimate.deflection_after.rms, std::sqrt(after / (3.0 * pairs)), 1e-12);
  EXPECT_NEAR(estimate.deflection_after.distance_max, farthest, 1e-12);
}

// Pairs of 18 arrivals determine the sigma of each axis by 54 degrees of freedom, by which the pairs scatter exactly:
// 3 x 54 of chi-square are theirs, whatever the model, and n = dof - 3 x 54 squares are left. With a third of them
// each, n_k = n / 3, the sum over n is the mean of three F(n_k, 54), of mean m = 54 / 52 and variance v / 3; it is
// compared with c F(n, nu) of that mean and variance.
TEST(RecomputedFigures, LackOfFitAgainstFewRepeats) {
  test::RepeatDesign design;
  design.configurations = 18;
  design.repeats = 2;
  design.joint = 0.0;
  Measurements data = test::RepeatRows(design);
  const test::Kr270Truth truth;
  test::MeasureRepeated(truth, design, 5, &data);
  Experiment experiment;
  experiment.noise.from = NoiseSpec::From::kRepeats;
  const CalibrationProblem problem = test::Kr270ProblemOf(data, experiment);
  ASSERT_TRUE(problem.repeat_scatter);
  EXPECT_EQ(problem.repeat_scatter->dof, 18 * 3);  // one of each pair, per axis
  const Estimate estimate = EstimateJointly(problem);
  const double of_axis = 18 * 3, of_pairs = 3 * of_axis;
  const double n = estimate.dof - of_pairs, reduced = (estimate.chi2 - of_pairs) / n, mean = of_axis / (of_axis - 2.0);
  const auto relative_variance = [](double m, double nu) { return 2.0 * (m + nu - 2.0) / (m * (nu - 4.0)); };
  const double wanted = relative_variance(n / 3.0, of_axis) / 3.0;
  double low = 5.0, high = 1e6;  // nu
  for (int k = 0; k < 200; ++k) (relative_variance(n, 0.5 * (low + high)) > wanted ? low : high) = 0.5 * (low + high);
  const double factor = mean * (low - 2.0) / low;
  EXPECT_NEAR(estimate.sigma.p_value, FSurvival(reduced / factor, n, low), 1e-9);
  EXPECT_GT(std::abs(estimate.sigma.p_value - ChiSquareSurvival(estimate.chi2 - of_pairs, n)), 1e-3);
}

TEST(RecomputedFigures, TheArmsShareOfAPredictionGrowsWithTheNoise) {
  Experiment experiment;
  experiment.repeatability.angle.common = 20e-6;
  test::Kr270Design design;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 4, &data);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, experiment);
  const Estimate estimate = EstimateJointly(problem);
  const auto of = [&](double scale) { return test::CovariancesWithoutNoise(problem, estimate, {0, 5, 17}, scale); };
  const auto one = of(1.0), three = of(3.0);
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_GT(one[k].arm.trace(), 1e-12);
    EXPECT_LT((three[k].arm - 9.0 * one[k].arm).norm(), 1e-12 * three[k].arm.norm());
    EXPECT_LT((three[k].parameters - one[k].parameters).norm(), 1e-15 * one[k].parameters.norm());
  }
}

}  // namespace
}  // namespace sagitta::recomputed_figures_test
