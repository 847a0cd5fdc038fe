// The words are a promise: the experiment they name is simulated, by the
// independent generator, and must bring the precision they state.
#include "estimator/calibration/load_remedy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/linearization.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::load_remedy_test {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

test::LoadedTruth VerticalBase() {
  test::LoadedTruth truth;
  truth.base_rotvec = {{0, 0, 0.3}, {0, 0, -1.0}};
  return truth;
}

CalibrationProblem Simulate(const test::LoadedTruth& truth, const test::LoadedDesign& design, Measurements data,
                            const test::LoadedSetup& setup) {
  test::Measure(test::ExactPoints(truth, data), design.sigma, 3, &data);
  return MakeCalibrationProblem(setup.robot, data, setup.experiment);
}

// Adds one shot of the design's markers per planned wrench.
void AddPlannedShots(const LoadPlan& plan, double sigma, test::LoadedTruth* truth, Measurements* data) {
  for (size_t i = 0; i < plan.configurations.size(); ++i) {
    int configuration = 0;
    while (data->configurations[configuration].id != plan.configurations[i]) ++configuration;
    Shot shot;
    for (const Shot& other : data->shots) {
      if (other.configuration == configuration) shot = other;
    }
    shot.load = shot.visit = "plan" + std::to_string(i);  // a pull is an arrival of its own
    const AppliedWrench& wrench = plan.wrenches[i];
    truth->loads[shot.load] = {wrench.force, wrench.moment, wrench.point, wrench.expressed_in};
    shot.wrench = {wrench.force, wrench.moment};
    test::AddShot(shot, 3, sigma, data);
  }
}

// Where the arm finds no equilibrium there is nothing to judge: a named status, not the numbers that happen to be
// there.
TEST(ComputeStatistics, AFoldedArmIsNoEstimate) {
  const test::LoadedTruth truth = VerticalBase();
  const test::LoadedDesign design;
  const CalibrationProblem problem = Simulate(truth, design, test::LoadedRows(design, truth), test::SetupFor(truth));
  Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status));
  const int k2 = estimate.parameters.FindCoordinate("compliance/A2");
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(estimate.parameters.num_coordinates());
  delta[k2] = 1e-2;  // rad/Nm
  estimate.parameters.Plus(delta);
  const std::vector<int> rows = problem.CalibrationObservations();
  const Linearization folded = Linearize(problem, estimate.parameters, rows, {}, ObservationNoise(problem, rows, 1e-3));
  ASSERT_FALSE(folded.valid);
  EXPECT_TRUE(std::isnan(folded.residual.squaredNorm()));
  ComputeStatistics(problem, &estimate);
  EXPECT_EQ(estimate.status, Status::kEquilibriumDiverged);
  EXPECT_FALSE(estimate.message.empty());
}

TEST(LoadRemedy, PulledAsItSaysTheCompliancePrecisionIsReached) {
  test::LoadedTruth truth = VerticalBase();
  const test::LoadedDesign design;
  Measurements data = test::LoadedRows(design, truth);
  const CalibrationProblem problem = Simulate(truth, design, data, test::SetupFor(truth));
  const Estimate before = EstimateJointly(problem);
  ASSERT_EQ(before.status, Status::kConvergedWithHeldParameters) << before.message;
  ASSERT_EQ(before.identifiability.unidentifiable.size(), 1u);
  EXPECT_THAT(before.identifiability.unidentifiable[0].remedy,
              MatchesRegex("pull sideways with 500 N in three configurations, e.g. C[0-9]+, C[0-9]+, C[0-9]+: "
                           "compliance/A1 to about 0.0[0-9]+ urad/Nm"));
  const int k1 = before.parameters.FindCoordinate("compliance/A1");
  const LoadPlan plan = PlanPulls(problem, before, k1, 500.0);
  ASSERT_EQ(plan.configurations.size(), 3u);
  for (const AppliedWrench& wrench : plan.wrenches) {
    EXPECT_NEAR(wrench.force.norm(), 500.0, 1e-9);
    EXPECT_NEAR(wrench.force.z(), 0.0, 1e-9);
  }
  AddPlannedShots(plan, design.sigma, &truth, &data);
  const Estimate after = EstimateJointly(Simulate(truth, design, data, test::SetupFor(truth)));
  ASSERT_EQ(after.status, Status::kConverged) << after.message;
  EXPECT_NEAR(after.table[k1].sigma, plan.sigma, 0.02 * plan.sigma);
  EXPECT_NEAR(after.table[k1].value, truth.k[0], 4 * plan.sigma);
  // Half the force, twice the uncertainty; the best three beat the first three.
  EXPECT_NEAR(PlanPulls(problem, before, k1, 250.0).sigma, 2 * plan.sigma, 0.1 * plan.sigma);
}

// An arm that carries 3 kg is not pulled with 50.
TEST(LoadRemedy, AnArmIsPulledWithNoMoreThanItIsKnownToCarry) {
  test::LoadedTruth truth = VerticalBase();
  truth.loads["V250"].force *= 3.0 / 250.0;
  const test::LoadedDesign design;
  const CalibrationProblem problem = Simulate(truth, design, test::LoadedRows(design, truth), test::SetupFor(truth));
  const Estimate estimate = EstimateJointly(problem);
  std::string remedies;
  for (const Direction& direction : estimate.identifiability.unidentifiable) remedies += direction.remedy + "\n";
  EXPECT_THAT(remedies, HasSubstr("pull sideways with 29 N"));
  EXPECT_THAT(remedies, Not(HasSubstr("500 N")));
}

TEST(LoadRemedy, ThePromiseCountsTheJointsRepeatability) {
  test::LoadedTruth truth = VerticalBase();
  const test::LoadedDesign design;
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.experiment.repeatability.angle.common = 40e-6;
  Measurements data = test::LoadedRows(design, truth);
  const CalibrationProblem problem = Simulate(truth, design, data, setup);
  const Estimate before = EstimateJointly(problem);
  const int k1 = before.parameters.FindCoordinate("compliance/A1");
  ASSERT_TRUE(before.parameters.coordinates()[k1].held);
  const LoadPlan plan = PlanPulls(problem, before, k1, 500.0);
  AddPlannedShots(plan, design.sigma, &truth, &data);
  setup.experiment.loads = test::SetupFor(truth).experiment.loads;
  const Estimate after = EstimateJointly(Simulate(truth, design, data, setup));
  ASSERT_EQ(after.status, Status::kConverged) << after.message;
  EXPECT_NEAR(after.table[k1].sigma, plan.sigma, 0.02 * plan.sigma);
}

TEST(LoadRemedy, ALoadOnTheAxisIsToBeHungBesideIt) {
  test::LoadedTruth truth = VerticalBase();
  truth.base_rotvec = {{0.05, 0, 0.3}, {0.05, 0, -1.0}};
  truth.loads["V250"].point = {0.28, 0, 0};
  const test::LoadedDesign design;
  const CalibrationProblem problem = Simulate(truth, design, test::LoadedRows(design, truth), test::SetupFor(truth));
  const Estimate before = EstimateJointly(problem);
  ASSERT_EQ(before.identifiability.unidentifiable.size(), 1u);
  const std::string remedy = before.identifiability.unidentifiable[0].remedy;
  EXPECT_THAT(remedy, HasSubstr("hang the load 100 mm off the axis (e.g. at [280, "));
  EXPECT_THAT(remedy, HasSubstr("compliance/A6 to about"));
  EXPECT_THAT(remedy, Not(HasSubstr("inf")));
  const int k6 = before.parameters.FindCoordinate("compliance/A6");
  EXPECT_GT(PlanPulls(problem, before, k6, 500.0).sigma, 1e-3);
}

TEST(LoadRemedy, LeavesOtherDirectionsAlone) {
  test::LoadedTruth truth = VerticalBase();
  truth.base_rotvec = {{0.05, 0, 0.3}, {0.05, 0, -1.0}};
  const test::LoadedDesign design;
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.robot.chain.transforms.back().error = "p_x6";
  setup.experiment.estimate.geometry.kind = Selection::Kind::kAll;
  const Estimate estimate = EstimateJointly(Simulate(truth, design, test::LoadedRows(design, truth), setup));
  ASSERT_EQ(estimate.identifiability.unidentifiable.size(), 1u);
  EXPECT_THAT(estimate.identifiability.unidentifiable[0].remedy, HasSubstr("marker"));
}

}  // namespace
}  // namespace sagitta::load_remedy_test
