// What a controller computes with, through calibrations of what earlier ones found.
#include <gtest/gtest.h>

#include "problems/calibration_problem.h"
#include "problems/io/robot_file.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::controller_kinematics_test {
namespace {

// The robot of a calibration that found this of an error.
Robot Calibrated(const Robot& robot, const std::string& error, double value) {
  const Measurements data = test::DesignMeasurements(test::Kr270Design());
  const CalibrationProblem problem = MakeCalibrationProblem(robot, data, Experiment());
  ParameterSet found = problem.parameters;
  for (int i = 0; i < problem.model().num_parameters(); ++i) {
    if (problem.model().parameters()[i].name == "geometry/" + error) found.SetModelValue(i, value);
  }
  return ReadRobotText(RobotToYaml(problem.RobotWith(found)), "robot.yaml");
}

double NominalOf(const Chain& chain, const std::string& error) {
  for (const ElementaryTransform& transform : chain.transforms) {
    if (transform.error == error) return transform.nominal;
  }
  return NAN;
}

TEST(ControllerKinematics, AreThoseBeforeAllCalibrations) {
  Robot robot;
  robot.chain = test::Kr270Chain();
  const double nominal = NominalOf(robot.chain, "p_x2");
  const Robot once = Calibrated(robot, "p_x2", 1e-3), twice = Calibrated(once, "p_x2", 2e-4);
  ASSERT_TRUE(once.controller && twice.controller);
  EXPECT_NEAR(NominalOf(once.chain, "p_x2"), nominal + 1e-3, 1e-12);
  EXPECT_NEAR(NominalOf(twice.chain, "p_x2"), nominal + 1.2e-3, 1e-12);
  EXPECT_NEAR(NominalOf(once.controller->chain, "p_x2"), nominal, 1e-12);
  EXPECT_NEAR(NominalOf(twice.controller->chain, "p_x2"), nominal, 1e-12);
}

TEST(ControllerKinematics, AreNotStatedWhereNothingMoved) {
  Robot robot;
  robot.chain = test::Kr270Chain();
  EXPECT_FALSE(Calibrated(robot, "p_x2", 0.0).controller.has_value());
}

}  // namespace
}  // namespace sagitta::controller_kinematics_test
