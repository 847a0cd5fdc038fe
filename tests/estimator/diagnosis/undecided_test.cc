// Where the data do not decide which effects the robot has, the intervals of what is written hold the truth all the
// same.
#include "estimator/diagnosis/undecided.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/sagitta.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::undecided_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// Two rivals of 0.1 and 0.05 against 0.05, of sets that have more in all: T of a length that they move by 2 mm and by
// -1 mm is 0.5 * 4 + 0.25 * 1 mm^2.
TEST(Undecided, RivalsCountByTheirProbability) {
  const CalibrationProblem problem = test::Kr270Problem({}, {}, 1);
  const Estimate estimate = EstimateJointly(problem);
  const auto moved = [&](double by) {
    ParameterSet parameters = estimate.parameters;
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters.num_coordinates());
    delta[estimate.estimated[0]] = by;
    parameters.Plus(delta);
    return parameters;
  };
  const BetweenParts found = ErrorOfChoice(estimate, 0.05, {{0.1, {}, moved(2e-3)}, {0.05, {}, moved(-1e-3)}});
  ASSERT_TRUE(found.known());
  EXPECT_NEAR(found.variance[0], 2.25e-6, 1e-15);
  EXPECT_NEAR(found.covariance.sum(), 2.25e-6, 1e-15);
  EXPECT_FALSE(ErrorOfChoice(estimate, 1.0, {}).known());
  // In numbers next to the least that there are T would not be symmetric, and no reader would accept it.
  const RivalSet none = {1.9e-308, {}, moved(-1e-3)};
  EXPECT_FALSE(ErrorOfChoice(estimate, 1.0, {none}).known());
  EXPECT_EQ(ErrorOfChoice(estimate, 0.05, {{0.1, {}, moved(2e-3)}, {0.05, {}, moved(-1e-3)}, none}).covariance,
            found.covariance);
}

// A marker that is held, or a base that nothing places, rests elsewhere in a rival's fit, and what moves with it does,
// too: the same robot in another gauge, which predicts the same.
TEST(Undecided, WhatMovesWithAHeldValueIsNoErrorOfTheChoice) {
  const CalibrationProblem problem = test::Kr270Problem({}, {}, 1);
  Estimate estimate = EstimateJointly(problem);
  ParameterSet parameters = estimate.parameters;
  const int held = parameters.FindCoordinate("marker/P1/z");
  ASSERT_GE(held, 0);
  std::vector<int> others;
  std::remove_copy(estimate.estimated.begin(), estimate.estimated.end(), std::back_inserter(others), held);
  estimate.estimated = others;
  const auto count = static_cast<long>(estimate.estimated.size());
  estimate.held.coordinates = {held};
  estimate.held.slopes = Eigen::MatrixXd::Zero(count, 1);
  estimate.held.slopes(0, 0) = -1.0;
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters.num_coordinates());
  delta[held] = 0.1;
  delta[estimate.estimated[0]] = -0.1 + 1e-3;  // 1 mm is its own
  parameters.Plus(delta);
  const BetweenParts found = ErrorOfChoice(estimate, 0.5, {{0.5, {}, parameters}});
  ASSERT_TRUE(found.known());
  EXPECT_NEAR(found.variance[0], 0.5e-6, 1e-12);
  EXPECT_NEAR(found.covariance.trace(), 0.5e-6, 1e-12);
}

TEST(Undecided, AddsToWhatPartsOfTheDataShow) {
  BetweenParts choice, parts;
  choice.covariance = Eigen::MatrixXd::Constant(1, 1, 3.0);
  choice.variance = Eigen::VectorXd::Constant(1, 3.0);
  choice.draws = Eigen::VectorXd::Constant(1, std::numeric_limits<double>::infinity());
  AddTo(choice, &parts);
  EXPECT_EQ(parts.variance[0], 3.0);
  parts = {};
  parts.covariance = Eigen::MatrixXd::Constant(1, 1, 1.0);
  parts.variance = Eigen::VectorXd::Constant(1, 1.0);
  parts.draws = Eigen::VectorXd::Constant(1, 4.0);
  AddTo(choice, &parts);
  EXPECT_EQ(parts.covariance(0, 0), 4.0);
  EXPECT_NEAR(parts.draws[0], 16.0 / (1.0 / 4.0), 1e-12);  // Welch: (1 + 3)^2 / (1^2 / 4)
}

// Two stations see every pose, and one reads 200 ppm too long. Which of the two, or whether the other reads too short,
// is what the lengths of the arm would say, and they are unknown.
TEST(Undecided, IntervalsHoldWhicheverStationIsWrong) {
  const test::Kr270Truth truth;
  test::Kr270Design design;
  design.configurations = 60;
  design.sigma = 4e-5;
  Measurements data = test::SeenFromBothStations(design);
  for (size_t c = 0; c < data.configurations.size(); c += 5) data.configurations[c].is_validation = true;
  test::MeasureKr270(truth, design.sigma, 5, &data);
  for (Observation& observation : data.observations) {
    if (data.shots[observation.shot].station == 1) observation.point_in_station *= 1.0 + 2e-4;
  }
  const Diagnosis diagnosis = Diagnose(test::Kr270ProblemOf(data, Experiment()), DiagnosisOptions());
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.effects[0].candidate.spec.effect, "station_scale");
  EXPECT_LT(diagnosis.effects[0].probability, 0.9);
  EXPECT_THAT(diagnosis.cautions, Contains(HasSubstr("do not decide")));
  const Calibration extended = ExtendedCalibration(diagnosis);
  int lengths = 0, held = 0;
  for (const ParameterEstimate& row : extended.estimate.table) {
    if (row.name.rfind("geometry/", 0) != 0 || row.quantity != Quantity::kLength || !row.free) continue;
    const double value = test::TrueValue(truth, row.name);
    ++lengths;
    held += row.ci95.low <= value && value <= row.ci95.high;
  }
  ASSERT_GT(lengths, 5);
  EXPECT_GE(held, lengths - 1);
}

}  // namespace
}  // namespace sagitta::undecided_test
