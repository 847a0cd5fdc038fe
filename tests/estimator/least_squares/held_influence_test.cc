// Intervals that do not assume a held parameter to be exact: a grid whose flange never
// turns cannot separate the tool and the base.
#include "estimator/least_squares/held_influence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/validation/trust.h"
#include "problems/loads.h"
#include "problems/simulation.h"
#include "tests/support/constant_orientation.h"
#include "tests/support/judged.h"
#include "tests/support/predicted.h"
#include "tests/support/random_vector.h"

namespace sagitta::held_influence_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kSigma = 3e-5;  // m
constexpr double kRange = 1.0;   // m: PhysicalRange of a marker
constexpr double kQuantile = 1.959964;
const Vector3<double> kStatedTool(0.28, -0.05, -0.09);
const Eigen::Matrix3d kDown = test::Turn(Eigen::Vector3d::UnitY(), 0.5 * kPi);
// Turned about all axes, so that every component of the tool point shows.
const Eigen::Matrix3d kAskew = kDown * test::Turn(Eigen::Vector3d(1, 2, 3).normalized(), 1.2);

struct Grid {
  test::Kr270Truth truth;
  Selection::Kind geometry = Selection::Kind::kNone;

  Robot robot() const {
    Robot robot;
    robot.chain = test::Kr270Chain();
    return robot;
  }
  Measurements Measured(const Eigen::Matrix3d& target, int poses, std::uint64_t seed, double noise) const {
    Measurements data = test::ConstantOrientationGrid(target, poses, seed, kSigma);
    test::MeasureKr270(truth, noise, 100 + seed, &data);
    return data;
  }
  CalibrationProblem Problem(int poses, std::uint64_t seed) const {
    Experiment experiment;
    experiment.markers["P1"].point = kStatedTool;
    experiment.estimate.geometry.kind = geometry;
    return MakeCalibrationProblem(robot(), Measured(kDown, poses, seed, kSigma), experiment);
  }
  // Where to predict, with the true points.
  CalibrationProblem Elsewhere(const Eigen::Matrix3d& target, int poses, std::uint64_t seed) const {
    return MakeKnownProblem(robot(), Measured(target, poses, seed, 0.0), Experiment(), {});
  }
};

// Counts axes whose 95 % interval holds the true point; the largest and smallest sigma.
struct Tally {
  int inside = 0, all = 0;
  double largest = 0.0, smallest = 1e9;

  void Add(const Estimate& estimate, CalibrationProblem where) {
    where.parameters.CopyByName(estimate.parameters);
    std::vector<int> rows;
    for (size_t k = 0; k < where.data().observations.size(); ++k) rows.push_back(static_cast<int>(k));
    const Eigen::Matrix3Xd predicted = PredictPoints(where, where.parameters, rows);
    const auto covariances = test::CovariancesWithoutNoise(where, estimate, rows, 1.0);
    for (size_t k = 0; k < rows.size(); ++k) {
      const Vector3<double> error = predicted.col(k) - where.data().observations[k].point_in_station;
      for (int axis = 0; axis < 3; ++axis) {
        const double sigma = std::sqrt(covariances[k].mean()(axis, axis));
        inside += std::abs(error[axis]) <= kQuantile * sigma;
        ++all;
        largest = std::max(largest, sigma);
        smallest = std::min(smallest, sigma);
      }
    }
  }
  double share() const { return inside / static_cast<double>(all); }
};

TEST(HeldInfluence, AGridThatNeverTurnsTheFlangeSaysSoInWords) {
  Grid grid;
  grid.truth.errors.fill(0.0);
  const Estimate estimate = EstimateJointly(grid.Problem(60, 5));
  ASSERT_EQ(estimate.status, Status::kConvergedWithHeldParameters) << estimate.message;
  const std::vector<Direction>& directions = estimate.identifiability.unidentifiable;
  ASSERT_EQ(directions.size(), 3u);
  for (const Direction& direction : directions) {
    EXPECT_THAT(direction.words, AllOf(HasSubstr("base/S1/"), HasSubstr("marker/P1/"), HasSubstr("move together")));
    EXPECT_THAT(direction.remedy, HasSubstr("flange turned"));
  }
  // Depends on what is held: the base's position, by a metre; not its rotation.
  for (const char* axis : {"x", "y", "z"}) {
    const ParameterEstimate& position =
        estimate.table[estimate.parameters.FindCoordinate("base/S1/" + std::string(axis))];
    EXPECT_TRUE(position.conditional);
    EXPECT_LT(position.sigma, 1e-4);
    EXPECT_NEAR(position.unconditional_sigma, kRange, 0.01 * kRange);
    EXPECT_FALSE(estimate.table[estimate.parameters.FindCoordinate("base/S1/r" + std::string(axis))].conditional);
    EXPECT_NEAR(
        estimate.table[estimate.parameters.FindCoordinate("marker/P1/" + std::string(axis))].unconditional_sigma,
        kRange, 0.01 * kRange);
  }
}

// What is held is off by what it is off by, however much more than noise parts of the data differ by: 1 mm of one
// degree of freedom is +- 12.7 mm, and 1.96 kRange stays 1.96 kRange.
TEST(HeldInfluence, ModelErrorDoesNotMultiplyWhatIsHeld) {
  Grid grid;
  grid.truth.errors.fill(0.0);
  const CalibrationProblem problem = grid.Problem(60, 5);
  Estimate estimate = EstimateJointly(problem);
  const auto count = static_cast<long>(estimate.estimated.size());
  BetweenParts between;
  between.variance = Eigen::VectorXd::Zero(count);
  between.covariance = Eigen::MatrixXd::Zero(count, count);
  between.draws = Eigen::VectorXd::Ones(count);
  const int coordinate = estimate.parameters.FindCoordinate("base/S1/x");
  const auto at = std::find(estimate.estimated.begin(), estimate.estimated.end(), coordinate);
  between.variance[at - estimate.estimated.begin()] = 1e-6;
  test::JudgeTrust(problem, 1, &estimate, between);
  const ParameterEstimate& row = estimate.table[coordinate];
  EXPECT_NEAR(row.ci95.high - row.value, 12.7e-3, 1e-3);
  EXPECT_NEAR(row.unconditional_ci95.high - row.value, 1.96 * kRange, 0.02 * kRange);
  EXPECT_NEAR(row.value - row.unconditional_ci95.low, 1.96 * kRange, 0.02 * kRange);
  EXPECT_GT(row.unconditional_sigma, 0.99 * kRange);
}

// The tool is anywhere within the range that the program assumes: then intervals
// elsewhere hold in 95 % of the cases, and within the grid they stay tight.
TEST(HeldInfluence, IntervalsHoldElsewhereAndStayTightWithinTheGrid) {
  const int trials = 300;
  Grid grid;
  grid.truth.errors.fill(0.0);
  Tally elsewhere, within;
  NormalNumbers normal(17);
  for (int trial = 0; trial < trials; ++trial) {
    const Vector3<double> off = test::RandomVector(normal);
    grid.truth.tools[0] = kStatedTool + kRange * off;
    const Estimate estimate = EstimateJointly(grid.Problem(40, 1000 + trial));
    ASSERT_EQ(estimate.status, Status::kConvergedWithHeldParameters) << estimate.message;
    elsewhere.Add(estimate, grid.Elsewhere(kAskew, 2, 5000));  // two rows: the tool's error is common to both
    within.Add(estimate, grid.Elsewhere(kDown, 2, 6000));
  }
  // Rows and axes share the draw: count trials only. sqrt(0.95 * 0.05 / 300) = 1.26 %, four of them.
  EXPECT_NEAR(elsewhere.share(), 0.95, 4 * 0.0126);
  EXPECT_NEAR(within.share(), 0.95, 4 * 0.0126);
  EXPECT_GT(elsewhere.smallest, 0.1);
  EXPECT_LT(within.largest, kSigma);
}

// With geometry free and a real robot's errors nothing is exactly constant; what
// is said must hold all the same.
TEST(HeldInfluence, HoldsWithGeometryFree) {
  const int trials = 60;
  Grid grid;
  grid.geometry = Selection::Kind::kDefault;
  Tally elsewhere, within;
  NormalNumbers normal(23);
  for (int trial = 0; trial < trials; ++trial) {
    const Vector3<double> off = test::RandomVector(normal);
    grid.truth.tools[0] = kStatedTool + 0.01 * off;
    const Estimate estimate = EstimateJointly(grid.Problem(80, 1000 + trial));
    ASSERT_EQ(estimate.status, Status::kConvergedWithHeldParameters) << estimate.message;
    elsewhere.Add(estimate, grid.Elsewhere(kAskew, 1, 5000));
    within.Add(estimate, grid.Elsewhere(kDown, 1, 6000));
  }
  EXPECT_GE(elsewhere.share(), 0.95 - 4 * std::sqrt(0.95 * 0.05 / trials));
  EXPECT_GE(within.share(), 0.95 - 4 * std::sqrt(0.95 * 0.05 / trials));
  EXPECT_GT(elsewhere.largest, 1e-3);
  EXPECT_LT(within.largest, 2e-4);
}

}  // namespace
}  // namespace sagitta::held_influence_test
