// Tables of KUKA and FANUC end in a frame that faces the arm; their controllers show a flange that faces away.
#include "estimator/results/flange_side.h"

#include <gtest/gtest.h>

#include "models/constants.h"
#include "problems/io/import/robot_reading.h"
#include "tests/support/paths.h"

namespace sagitta::flange_side_test {
namespace {

Chain Shipped(const std::string& name) {
  return ReadAnyRobot(test::SourceFolder() + "/problems/published/robots/" + name + ".csv").robot.chain;
}

Pose<double> Turned(const Vector3<double>& rotation_vector) {
  Pose<double> pose;
  pose.rotation = RotationFromVector(rotation_vector);
  return pose;
}

TEST(FlangeSide, OfMakersTables) {
  for (const char* name : {"kr6_r900", "lrmate200id"}) {
    SCOPED_TRACE(name);
    EXPECT_TRUE(FacesTheArm(Shipped(name), Pose<double>()));
    EXPECT_FALSE(FacesTheArm(Shipped(name), Turned({kPi, 0.0, 0.0})));
    EXPECT_FALSE(FacesTheArm(Shipped(name), Turned({0.0, kPi, 0.0})));
    EXPECT_TRUE(FacesTheArm(Shipped(name), Turned({0.0, 0.0, kPi})));
  }
  for (const char* name : {"irb120", "tx60", "ur3", "ur5", "ur10"}) {
    SCOPED_TRACE(name);
    EXPECT_FALSE(FacesTheArm(Shipped(name), Pose<double>()));
    EXPECT_TRUE(FacesTheArm(Shipped(name), Turned({kPi, 0.0, 0.0})));
    EXPECT_FALSE(FacesTheArm(Shipped(name), Turned({kPi / 4.0, 0.0, 0.0})));  // no side
  }
}

}  // namespace
}  // namespace sagitta::flange_side_test
