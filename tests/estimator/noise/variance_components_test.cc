#include "estimator/noise/variance_components.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numeric>

#include "estimator/noise/repeatability.h"
#include "tests/support/noise_experiment.h"

namespace sagitta::variance_components_test {
namespace {

constexpr double kJoint = 37e-6;

struct Measured {
  CalibrationProblem problem;
  Estimate estimate;
};

Measured MakeMeasured(bool reapproached, std::uint64_t seed, int repeats = 3) {
  test::RepeatDesign design;
  design.repeats = repeats;
  design.reapproached = reapproached;
  Measurements data = test::RepeatRows(design);
  test::MeasureRepeated(test::Kr270Truth(), design, seed, &data);
  Measured setup{test::Kr270ProblemOf(data, Experiment()), {}};
  setup.estimate = EstimateJointly(setup.problem);
  return setup;
}

std::vector<DeviationGroup> PerJoint(const std::vector<double>& sigmas) {
  std::vector<DeviationGroup> groups;
  for (int j = 0; j < 6; ++j) groups.push_back({{j}, sigmas[j] * sigmas[j], true});
  return groups;
}

// ln|V| + ln|J'V^-1 J| + r'P r with V written out in full.
double DenseDeviance(const Measured& setup, double instrument, const std::vector<double>& sigmas) {
  CalibrationProblem problem = setup.problem;
  problem.latent.joints = {0, 1, 2, 3, 4, 5};
  problem.latent.sigmas = Eigen::Map<const Eigen::VectorXd>(sigmas.data(), 6);
  const std::vector<int> rows = problem.CalibrationObservations();
  const Linearization raw =
      Linearize(problem, setup.estimate.parameters, rows, setup.estimate.parameters.EstimatedCoordinates(),
                ObservationNoise(problem, rows, 1e-3), LatentTreatment::kIgnore);
  const int n = raw.num_rows();
  Eigen::MatrixXd v = instrument * Eigen::MatrixXd::Identity(n, n);
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) {
      const int a = problem.latent.visit_of_shot[problem.data().observations[rows[r / 3]].shot];
      const int b = problem.latent.visit_of_shot[problem.data().observations[rows[c / 3]].shot];
      if (a == b) v(r, c) += raw.latent.row(r).dot(raw.latent.row(c));
    }
  }
  const Eigen::MatrixXd j = raw.jacobian * raw.jacobian.colwise().norm().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse = v.inverse();
  const Eigen::MatrixXd normal = j.transpose() * inverse * j;
  const Eigen::VectorXd x = normal.ldlt().solve(j.transpose() * inverse * raw.residual);
  const Eigen::VectorXd rest = raw.residual - j * x;
  return 2.0 * Eigen::MatrixXd(v.llt().matrixL()).diagonal().array().log().sum() +
         2.0 * Eigen::MatrixXd(normal.llt().matrixL()).diagonal().array().log().sum() + rest.dot(inverse * rest);
}

TEST(VarianceComponents, DevianceIsThatOfTheDenseFormula) {
  for (const bool reapproached : {false, true}) {
    const Measured setup = MakeMeasured(reapproached, 5);
    const RestrictedLikelihood reml(setup.problem, setup.estimate.parameters);
    const std::vector<double> one = {2e-5, 4e-5, 1e-5, 3e-5, 6e-5, 5e-5}, other = {4e-5, 1e-5, 7e-5, 3e-5, 1e-6, 2e-5};
    const double difference = reml.Deviance(1.3, PerJoint(one)) - reml.Deviance(0.8, PerJoint(other));
    const double dense = DenseDeviance(setup, 1.3, one) - DenseDeviance(setup, 0.8, other);
    EXPECT_NEAR(difference, dense, 1e-6 * std::abs(dense));
  }
}

// No step of a ten-thousandth in any variance lowers the deviance; two-sided differences vanish inside.
TEST(VarianceComponents, MaximumIsOne) {
  const Measured setup = MakeMeasured(true, 6);
  const RestrictedLikelihood reml(setup.problem, setup.estimate.parameters);
  std::vector<DeviationGroup> groups = PerJoint({1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5});
  const RemlFit fit = reml.Maximise(true, groups);
  ASSERT_TRUE(fit.converged);
  for (int g = 0; g < 6; ++g) groups[g].variance = fit.variances[g + 1];
  const double best = reml.Deviance(fit.variances[0], groups);
  EXPECT_NEAR(best, fit.deviance, 1e-9 * std::abs(best));
  for (int i = 0; i < 7; ++i) {
    for (const double factor : {0.99, 1.01}) {
      std::vector<DeviationGroup> moved = groups;
      double instrument = fit.variances[0];
      (i == 0 ? instrument : moved[i - 1].variance) *= factor;
      const double rise = reml.Deviance(instrument, moved) - best;
      // Half the second derivative times the step squared: 0.5 * (0.01 v)^2 / (var / 2).
      const double expected = std::pow(0.01 * fit.variances[i], 2) / (2.0 * fit.covariance(i, i));
      EXPECT_GT(rise, 0.3 * expected) << i;
      EXPECT_LT(rise, 3.0 * expected) << i;
    }
  }
}

// A robot that repeats exactly: the boundary is found and the interval says so.
TEST(VarianceComponents, ExactJointsEndAtZeroOrCannotBeToldFromIt) {
  int at_zero = 0, held = 0;
  constexpr int kTrials = 12;
  for (int t = 0; t < kTrials; ++t) {
    test::RepeatDesign design;
    design.repeats = 3;
    design.joint = 0.0;
    Measurements data = test::RepeatRows(design);
    test::MeasureRepeated(test::Kr270Truth(), design, 300 + t, &data);
    Experiment experiment;
    experiment.repeatability.angle.estimate = true;
    const ResolvedEstimate result = EstimateWithNoise(test::Kr270ProblemOf(data, experiment));
    ASSERT_TRUE(IsUsable(result.estimate.status));
    const VarianceComponent& joints = result.estimate.noise_report.components[1];
    at_zero += joints.value == 0.0;
    held += joints.low == 0.0;
    EXPECT_LT(joints.value, 8e-6);
  }
  // The optimum is at 0 about every second time (Self and Liang 1987): P(Bin(12, 1/2) outside 1..11) < 0.001; the
  // interval excludes 0 in 2.5 %: P(Bin(12, 0.025) > 3) < 0.001.
  EXPECT_GE(at_zero, 1);
  EXPECT_LE(at_zero, 11);
  EXPECT_GE(held, kTrials - 3);
}

// Asking for the revolute joints' leaves what is stated for the prismatic one.
TEST(VarianceComponents, WhatIsStatedForTheOtherKindStays) {
  const Measured setup = MakeMeasured(false, 700);
  Robot robot = setup.problem.robot();
  robot.chain.joints[2].type = JointType::kPrismatic;
  robot.chain.transforms[robot.chain.JointTransform(2)].motion = Motion::kTranslation;
  Experiment experiment = setup.problem.experiment();
  experiment.repeatability = RepeatabilitySpec();
  experiment.repeatability.angle.estimate = true;
  experiment.repeatability.length.common = 5e-6;
  CalibrationProblem problem = MakeCalibrationProblem(robot, setup.problem.data(), experiment);
  std::vector<int> all(problem.data().observations.size());
  std::iota(all.begin(), all.end(), 0);
  // The residuals that the revolute arm had.
  const Eigen::Matrix3Xd shift =
      PredictPoints(problem, problem.parameters, all) - PredictPoints(setup.problem, setup.estimate.parameters, all);
  for (const int i : all) problem.mutable_data()->observations[i].point_in_station += shift.col(i);
  RepeatabilityChoice choice;
  FindComponents(problem, problem.parameters, true, 0, &choice);
  int stated = 0;
  for (const DeviationGroup& group : choice.groups) {
    const bool has_slide = std::count(group.joints.begin(), group.joints.end(), 2) > 0;
    EXPECT_EQ(group.estimated, !has_slide);
    if (!has_slide) continue;
    ++stated;
    EXPECT_EQ(group.joints.size(), 1u);
    EXPECT_NEAR(group.variance, 25e-12, 1e-24);
  }
  EXPECT_EQ(stated, 1);
}

// What plain maximum likelihood would not give: REML is unbiased. 30 draws; the mean of the estimated variance within
// four standard errors of the truth.
TEST(VarianceComponents, EstimatesAreUnbiasedAndIntervalsHold) {
  constexpr int kTrials = 30;
  double joint = 0.0, joint2 = 0.0, tracker = 0.0, tracker2 = 0.0;
  int covered = 0, separate = 0;
  for (int t = 0; t < kTrials; ++t) {
    const Measured setup = MakeMeasured(false, 700 + t);
    const RestrictedLikelihood reml(setup.problem, setup.estimate.parameters);
    const std::vector<DeviationGroup> groups = {{{0, 1, 2, 3, 4, 5}, 1e-10, true}};
    const RemlFit fit = reml.Maximise(true, groups);
    const double v = fit.variances[1] / (kJoint * kJoint), a = fit.variances[0];
    joint += v / kTrials;
    joint2 += v * v / kTrials;
    tracker += a / kTrials;
    tracker2 += a * a / kTrials;
    double low = 0.0, high = 0.0;
    reml.ProfileInterval(fit, true, groups, 1, &low, &high);
    covered += low <= kJoint && kJoint <= high;
    RepeatabilityChoice choice;
    CalibrationProblem asked = setup.problem;
    asked.mutable_experiment()->repeatability.angle.estimate = true;
    FindComponents(asked, setup.estimate.parameters, true, 0, &choice);
    separate += choice.per_joint;
  }
  const double joint_error = std::sqrt((joint2 - joint * joint) / kTrials);
  EXPECT_NEAR(joint, 1.0, 4 * joint_error);
  EXPECT_LT(joint_error, 0.06);  // the test has power: sd of a variance from about 75 degrees of freedom, over sqrt 30
  EXPECT_NEAR(tracker, 1.0, 4 * std::sqrt((tracker2 - tracker * tracker) / kTrials));
  EXPECT_GE(covered, 25);  // P(Bin(30, 0.95) < 25) < 0.004
  EXPECT_LE(separate, 1);  // one common value is the truth
}

}  // namespace
}  // namespace sagitta::variance_components_test
