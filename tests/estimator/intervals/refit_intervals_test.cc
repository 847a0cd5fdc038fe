// Bootstrap and profile-likelihood intervals against what is known of them.
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/intervals/bootstrap.h"
#include "estimator/intervals/profile.h"
#include "estimator/intervals/redraw.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/refit.h"
#include "estimator/least_squares/row_sums.h"
#include "estimator/statistics/distributions.h"
#include "problems/input_error.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/random_vector.h"

namespace sagitta::refit_intervals_test {
namespace {

TEST(Refit, FindsTheJointOptimum) {
  const test::Kr270Truth truth;
  const CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), truth, 3);
  const Estimate estimate = EstimateJointly(problem);
  ParameterSet start = estimate.parameters;
  Eigen::VectorXd off = Eigen::VectorXd::Zero(start.num_coordinates());
  for (size_t c = 0; c < estimate.estimated.size(); ++c) {
    off[estimate.estimated[c]] = (c % 2 == 0 ? 5.0 : -5.0) * std::sqrt(estimate.covariance(c, c));
  }
  start.Plus(off);
  RefitOptions options;
  options.steps.tolerance = 1e-7;
  const Refit refit = RefitFrom(problem, start, options);
  ASSERT_TRUE(refit.converged);
  const Eigen::VectorXd left = TangentDifference(refit.parameters, estimate.parameters);
  for (size_t c = 0; c < estimate.estimated.size(); ++c) {
    EXPECT_NEAR(left[estimate.estimated[c]], 0.0, 1e-5 * std::sqrt(estimate.covariance(c, c)));
  }
  EXPECT_NEAR(refit.chi2, 2.0 * estimate.cost, 1e-8 * estimate.cost);
}

TEST(Refit, AWeightOfTwoIsTheRowTwice) {
  const test::Kr270Truth truth;
  const CalibrationProblem once = test::Kr270Problem(test::Kr270Design(), truth, 4);
  CalibrationProblem twice = once;
  for (int k = 0; k < 3; ++k) {
    Observation copy = once.data().observations[k];
    Measurements& data = *twice.mutable_data();
    data.shots[copy.shot].observations.push_back(static_cast<int>(data.observations.size()));
    data.observations.push_back(copy);
  }
  const Estimate estimate = EstimateJointly(once);
  RefitOptions weighted;
  weighted.steps.tolerance = 1e-7;
  weighted.weights.assign(once.data().observations.size(), 1.0);
  for (int k = 0; k < 3; ++k) weighted.weights[k] = 2.0;
  RefitOptions plain;
  plain.steps.tolerance = 1e-7;
  const Refit a = RefitFrom(once, estimate.parameters, weighted);
  const Refit b = RefitFrom(twice, estimate.parameters, plain);
  ASSERT_TRUE(a.converged && b.converged);
  const Eigen::VectorXd difference = TangentDifference(b.parameters, a.parameters);
  for (size_t c = 0; c < estimate.estimated.size(); ++c) {
    EXPECT_NEAR(difference[estimate.estimated[c]], 0.0, 1e-5 * std::sqrt(estimate.covariance(c, c)));
  }
}

// Parametric draws at a nearly linear problem: normal about the estimate, so the
// studentised ends are those of the model but for the error of 999 draws. Of a
// 2.5 % quantile that is sqrt(p (1 - p) / n) / phi(q) = 0.085 sigma; 78 ends, 4.5 of them.
TEST(Bootstrap, ParametricAgreesWithTheModelWhereTheModelHolds) {
  const test::Kr270Truth truth;
  CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), truth, 3);
  for (Observation& observation : problem.mutable_data()->observations)
    observation.sigma.setZero();  // estimated: Student's t
  const Estimate model = EstimateJointly(problem);
  Estimate drawn = model;
  BootstrapOptions options;
  options.num_threads = 2;
  BootstrapIntervals(problem, options, &drawn);
  EXPECT_EQ(drawn.intervals.kind, BootstrapKind::kParametric);  // 18 configurations are too few to be drawn from
  EXPECT_EQ(drawn.intervals.replicates, 999);
  for (const int i : model.estimated) {
    const ParameterEstimate& a = model.table[i];
    const ParameterEstimate& b = drawn.table[i];
    EXPECT_NEAR(b.ci95.low, a.ci95.low, 4.5 * 0.085 * a.sigma) << a.name;
    EXPECT_NEAR(b.ci95.high, a.ci95.high, 4.5 * 0.085 * a.sigma) << a.name;
    EXPECT_NEAR(b.sigma / a.sigma, 1.0, 4.5 / std::sqrt(2.0 * 999)) << a.name;
  }
}

// Where refits pile up at a bound their quantiles say nothing of what the data leave possible: [0, 0] at worst.
TEST(Bootstrap, AtABoundItHoldsWhatTheModelHolds) {
  CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), test::Kr270Truth(), 5);
  const Estimate free = EstimateJointly(problem);
  const int i = free.parameters.FindCoordinate("geometry/p_x1");
  ASSERT_GE(i, 0);
  problem.parameters.coordinate(i).lower = free.parameters.Value(i) + 1.5 * free.table[i].sigma;
  const Estimate model = EstimateJointly(problem);
  ASSERT_EQ(model.parameters.Value(i), problem.parameters.coordinate(i).lower);
  Estimate drawn = model;
  BootstrapOptions options;
  options.replicates = 199;
  options.num_threads = 2;
  BootstrapIntervals(problem, options, &drawn);
  EXPECT_GE(drawn.table[i].ci95.high, model.table[i].ci95.high);
  EXPECT_GT(drawn.table[i].ci95.high - drawn.table[i].ci95.low, free.table[i].sigma);
  EXPECT_TRUE(drawn.table[i].at_bound);
}

TEST(Bootstrap, DoesNotDependOnTheNumberOfThreads) {
  const test::Kr270Truth truth;
  const CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), truth, 5);
  const Estimate model = EstimateJointly(problem);
  Estimate one = model, two = model, other = model;
  BootstrapOptions options;
  options.replicates = 99;
  BootstrapIntervals(problem, options, &one);
  options.num_threads = 2;
  BootstrapIntervals(problem, options, &two);
  options.seed = 2;
  BootstrapIntervals(problem, options, &other);
  EXPECT_EQ((one.covariance - two.covariance).norm(), 0.0);
  EXPECT_GT((one.covariance - other.covariance).norm(), 0.0);
  for (const int i : model.estimated) EXPECT_EQ(one.table[i].ci95.low, two.table[i].ci95.low);
}

// Errors that all rows of a configuration share and nobody declared: draws of
// configurations see them, the model's intervals (18 of 20 here too narrow) do not.
TEST(Bootstrap, OfConfigurationsSeesWhatAConfigurationShares) {
  test::Kr270Design design;
  design.configurations = 120;
  design.stations = 1;
  const test::Kr270Truth truth;
  CalibrationProblem problem = test::Kr270Problem(design, truth, 6);
  NormalNumbers normal(8);
  for (const Shot& shot : problem.data().shots) {
    const Vector3<double> shared = 4e-4 * test::RandomVector(normal);
    for (const int k : shot.observations) problem.mutable_data()->observations[k].point_in_station += shared;
  }
  const Estimate model = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(model.status));
  Estimate drawn = model;
  BootstrapOptions options;
  options.num_threads = 2;
  options.replicates = 399;
  BootstrapIntervals(problem, options, &drawn);
  EXPECT_EQ(drawn.intervals.kind, BootstrapKind::kConfigurations);
  EXPECT_EQ(drawn.intervals.clusters, 120);
  // A geometric error that moves all markers alike: its variance is that of the
  // shared error, 3 times what rows say that are assumed to be independent.
  const int i = model.parameters.FindCoordinate("base/S1/x");
  EXPECT_GT(drawn.table[i].sigma, 1.4 * model.table[i].sigma);
}

// More rows than are kept (row_sums.h): refits hold condensed ones, and the scores of the configurations come from the
// rows themselves. Independent errors: the bootstrap's intervals are the model's but for its few draws. Of 39 normal
// numbers the largest is the end of the interval: below 0.7 it lies once in 50 000 times, above 4.5 once in 7000.
TEST(Bootstrap, OfConfigurationsTakesMoreRowsThanAreKept) {
  test::Kr270Design design;
  design.configurations = 7000;
  design.stations = 1;
  const CalibrationProblem problem = test::Kr270Problem(design, test::Kr270Truth(), 6);
  const Estimate model = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(model.status));
  ASSERT_FALSE(AreHeld(3.0 * problem.data().observations.size(), model.estimated.size()));
  Estimate drawn = model;
  BootstrapOptions options;
  options.replicates = 99;
  BootstrapIntervals(problem, options, &drawn);
  ASSERT_EQ(drawn.intervals.kind, BootstrapKind::kConfigurations);
  ASSERT_EQ(drawn.intervals.method, CovarianceKind::kBootstrap);
  for (const int i : model.estimated) {
    const double low = model.table[i].value - drawn.table[i].ci95.low;
    const double high = drawn.table[i].ci95.high - model.table[i].value;
    for (const double end : {low, high}) {
      EXPECT_GT(end, 0.7 * model.table[i].sigma) << model.table[i].name;
      EXPECT_LT(end, 4.5 * model.table[i].sigma) << model.table[i].name;
    }
  }
}

TEST(Bootstrap, TooFewConfigurationsToDrawFromAreRefused) {
  const CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), test::Kr270Truth(), 5);
  Estimate estimate = EstimateJointly(problem);
  BootstrapOptions options;
  options.kind = BootstrapKind::kConfigurations;
  EXPECT_THROW(BootstrapIntervals(problem, options, &estimate), InputError);
}

TEST(Profile, AgreesWithTheEllipseWhereThereIsNothingToBend) {
  const CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), test::Kr270Truth(), 7);
  const Estimate model = EstimateJointly(problem);
  Estimate profile = model;
  ProfileIntervals(problem, {}, &profile);
  EXPECT_EQ(profile.intervals.method, CovarianceKind::kProfile);
  EXPECT_EQ(profile.intervals.failed, 0);
  for (const int i : model.estimated) {
    // Curvature of the arm over one standard deviation (0.1 mrad): 1e-4; the root is found to 1e-3.
    EXPECT_NEAR(profile.table[i].ci95.low, model.table[i].ci95.low, 0.01 * model.table[i].sigma);
    EXPECT_NEAR(profile.table[i].ci95.high, model.table[i].ci95.high, 0.01 * model.table[i].sigma);
  }
}

// The definition itself, by brute force: at the end of the interval the fit with
// the parameter fixed there is worse by the quantile squared.
TEST(Profile, EndsAreWhereTheConstrainedFitIsWorseByTheQuantile) {
  test::LoadedTruth truth;
  truth.spring = test::SpringTruth();
  truth.link_markers = {{"B1", {0, {0.3, 0.2, 0.1}}}, {"B2", {1, {0.1, 0.2, 0.15}}}};
  test::LoadedDesign design;
  const test::LoadedSetup setup = test::SetupFor(truth);
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), design.sigma, 9, &data);
  const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  const double scale = estimate.sigma.scaled ? estimate.sigma.a_posteriori : 1.0;
  const double t = estimate.sigma.scaled ? StudentQuantile(0.975, estimate.dof) : NormalQuantile(0.975);
  ProfileOptions options;
  options.num_threads = 2;
  ProfileIntervals(problem, options, &estimate);
  int checked = 0;
  for (const char* name : {"compensator/a_x", "compensator/s0", "compensator/Kc"}) {
    const int i = estimate.parameters.FindCoordinate(name);
    const ParameterEstimate& row = estimate.table[i];
    if (!row.free) continue;
    for (const double end : {row.ci95.low, row.ci95.high}) {
      if (row.open_low || row.open_high) continue;
      CalibrationProblem fixed = problem;
      Estimate there;
      ParameterSet start = estimate.parameters;
      Eigen::VectorXd move = Eigen::VectorXd::Zero(start.num_coordinates());
      move[i] = end - row.value;
      start.Plus(move);
      start.coordinate(i).free = false;
      const Estimate constrained = EstimateFrom(fixed, start);
      ASSERT_TRUE(IsUsable(constrained.status)) << constrained.message;
      const double gained = 2.0 * (constrained.cost - estimate.cost) / (scale * scale);
      EXPECT_NEAR(std::sqrt(gained), t, 0.005 * t) << name;
      ++checked;
    }
  }
  EXPECT_GE(checked, 4);
}

TEST(Redraw, HasTheNoiseAndRepeatabilityOfTheProblem) {
  CalibrationProblem problem = test::Kr270Problem(test::Kr270Design(), test::Kr270Truth(), 1);
  problem.latent.joints = {0};
  problem.latent.sigmas = Eigen::VectorXd::Constant(1, 50e-6);
  problem.latent.num_visits = static_cast<int>(problem.data().shots.size());
  problem.latent.visit_of_shot.clear();
  for (size_t s = 0; s < problem.data().shots.size(); ++s) problem.latent.visit_of_shot.push_back(static_cast<int>(s));
  ParameterSet truth = problem.parameters;
  const std::vector<int> row = {0};
  const Vector3<double> exact = PredictPoints(problem, truth, row);
  const Simulator redraw = RedrawAt(problem, truth, 2.0, 1e-3);
  Measurements data = problem.data();
  const int draws = 4000;
  Matrix3<double> covariance = Matrix3<double>::Zero();
  for (int i = 0; i < draws; ++i) {
    ASSERT_TRUE(redraw.Draw(SeedOf(3, i), &data));
    const Vector3<double> error = data.observations[0].point_in_station - exact;
    covariance += error * error.transpose() / draws;
  }
  // About A1 the point moves by 2 * 50 urad * its distance, at right angles to it; sigma 2 * 0.1 mm.
  const Vector3<double> tangent = Vector3<double>::UnitZ().cross(exact);  // base and station frames coincide
  const Matrix3<double> expected = 4.0 * (1e-8 * Matrix3<double>::Identity() + 2.5e-9 * tangent * tangent.transpose());
  EXPECT_LT((covariance - expected).norm(), 6.0 * expected.norm() / std::sqrt(draws));
}

}  // namespace
}  // namespace sagitta::refit_intervals_test
