// Rows whose stated sigmas are a tracker's while the robot scatters by far more: found by maximum likelihood, weighed
// by both, and no worse where the statement is right.
#include "estimator/noise/robot_scatter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/calibration/noise_loop.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::robot_scatter_test {
namespace {

constexpr double kTau = 2.5e-4;  // m
constexpr int kConfigurations = 60;

// Sigmas from 0.5 to 50 um, log-uniform, as real trackers state them row by row.
CalibrationProblem Measured(double tau, std::uint64_t seed, NoiseSpec::From from) {
  test::Kr270Design design;
  design.configurations = kConfigurations;
  design.stations = 1;
  Measurements data = test::DesignMeasurements(design);
  const test::Kr270Truth truth;
  test::MeasureKr270(truth, 0.0, 1, &data);
  test::RandomNumbers random(seed);
  NormalNumbers normal(seed);
  for (Observation& row : data.observations) {
    row.sigma.setConstant(5e-7 * std::pow(100.0, random.Uniform(0, 1)));
    for (int axis = 0; axis < 3; ++axis) row.point_in_station[axis] += row.sigma[axis] * normal() + tau * normal();
  }
  Experiment experiment;
  experiment.noise.from = from;
  return test::Kr270ProblemOf(data, experiment);
}

double ErrorOf(const CalibrationProblem& problem, const Estimate& estimate) {
  const test::Kr270Truth truth;
  std::vector<int> all;
  for (size_t i = 0; i < problem.data().observations.size(); ++i) all.push_back(static_cast<int>(i));
  const Eigen::Matrix3Xd predicted = PredictPoints(problem, estimate.parameters, all);
  double squares = 0.0;
  for (const int i : all)
    squares +=
        (predicted.col(i) - test::ExactPoint(truth, problem.data(), problem.data().observations[i])).squaredNorm();
  return std::sqrt(squares / (3.0 * all.size()));
}

TEST(RobotScatter, IsFoundAndMakesTheFitBetter) {
  double by_both = 0.0, by_stated = 0.0;
  for (int seed = 1; seed <= 5; ++seed) {
    const CalibrationProblem problem = Measured(kTau, seed, NoiseSpec::From::kDefault);
    const ResolvedEstimate found = EstimateWithNoise(problem);
    ASSERT_TRUE(IsUsable(found.estimate.status)) << found.estimate.message;
    // 540 coordinates less 33 unknowns: 3.1 % of a standard deviation, and what the unknowns absorb (3 %).
    EXPECT_NEAR(FindRobotScatter(problem, found.estimate).tau, kTau, (4 * 0.031 + 0.03) * kTau);
    const ResolvedEstimate stated = EstimateWithNoise(Measured(kTau, seed, NoiseSpec::From::kRows));
    EXPECT_TRUE(stated.problem.resolved_noise.empty());
    by_both += std::pow(ErrorOf(problem, found.estimate), 2);
    by_stated += std::pow(ErrorOf(problem, stated.estimate), 2);
    // The intervals are those of the scatter: least squares of equal weights, sigma tau.
    EXPECT_TRUE(found.estimate.sigma.scaled);
    EXPECT_NEAR(std::sqrt(by_both / seed), kTau * std::sqrt(36.0 / 540.0), 0.4 * kTau * std::sqrt(36.0 / 540.0));
  }
  EXPECT_LT(by_both, 0.5 * by_stated);
}

TEST(RobotScatter, IsNotLookedForWhereTheSigmasAreRight) {
  const ResolvedEstimate found = EstimateWithNoise(Measured(0.0, 3, NoiseSpec::From::kDefault));
  ASSERT_TRUE(IsUsable(found.estimate.status));
  EXPECT_FALSE(ScattersByRobot(found.problem, found.estimate));
  EXPECT_TRUE(found.problem.resolved_noise.empty());
}

}  // namespace
}  // namespace sagitta::robot_scatter_test
