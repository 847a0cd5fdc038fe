// A stated coupling is of the command: what is said of it, and of which arms.
#include "estimator/calibration/coupled_joints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/loaded_kr270.h"

namespace sagitta::coupled_joints_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::StartsWith;

CalibrationProblem With(const std::vector<Coupling>& couplings) {
  const test::LoadedTruth truth;
  const test::LoadedDesign design;
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.robot.chain.couplings = couplings;
  return MakeCalibrationProblem(setup.robot, test::LoadedRows(design, truth), setup.experiment);
}

TEST(CoupledJoints, AJointThatFollowsOneThatGivesWayIsSaid) {
  EXPECT_THAT(WarningsOfCouplings(With({{2, 1, -1.0}})),
              ElementsAre(StartsWith("A3 follows the command of A2 and not")));
  EXPECT_THAT(WarningsOfCouplings(With({})), IsEmpty());
}

TEST(CoupledJoints, OfAnArmWithoutCompliancesItMattersToEffectsAlone) {
  Robot robot;
  robot.chain = test::Kr270Chain();
  robot.chain.couplings = {{2, 1, -1.0}};
  Measurements data = test::DesignMeasurements({6, 1, 1, 1e-4});
  test::MeasureKr270(test::Kr270Truth(), 1e-4, 1, &data);
  const CalibrationProblem problem = MakeCalibrationProblem(robot, data, Experiment());
  EXPECT_THAT(WarningsOfCouplings(problem), IsEmpty());
  EXPECT_EQ(WarningsOfCouplings(problem, true).size(), 1u);
}

}  // namespace
}  // namespace sagitta::coupled_joints_test
