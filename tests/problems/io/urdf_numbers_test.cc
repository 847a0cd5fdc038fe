// Numbers of a URDF and couplings that go with it: in m and rad, by line and joint, and once.
#include <gtest/gtest.h>

#include "models/constants.h"
#include "problems/io/robot_file.h"
#include "problems/io/urdf_robot.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::urdf_numbers_test {
namespace {

const char kArm[] =
    "<?xml version='1.0'?>\n"
    "<robot name='r'><link name='base_link'/><link name='l1'/><link name='l2'/><link name='tool'/>\n"
    "<joint name='j1' type='revolute'><parent link='base_link'/><child link='l1'/>\n"
    "  <origin xyz='0 0 0.4' rpy='0 0 0'/><axis xyz='0 0 1'/><limit lower='-3' upper='3' effort='1' "
    "velocity='1'/></joint>\n"
    "<joint name='j2' type='revolute'><parent link='l1'/><child link='l2'/>\n"
    "  <origin xyz='0.1 0 0' rpy='0 1.57 0'/><axis xyz='0 1 0'/><limit lower='-2' upper='2' effort='1' "
    "velocity='1'/></joint>\n"
    "<joint name='jt' type='fixed'><parent link='l2'/><child link='tool'/><origin xyz='0.3 0 0' rpy='0 0 0'/></joint>\n"
    "</robot>\n";

std::string ErrorWith(const std::string& from, const std::string& to) {
  return ErrorOf([&] { ReadUrdfText(Replaced(kArm, from, to), "arm.urdf"); });
}

TEST(UrdfNumbers, AreNamedByLineJointAndAttribute) {
  EXPECT_EQ(ErrorWith("0.1 0 0", "0.1 0 0"), "");
  EXPECT_TRUE(SaysInOrder(ErrorWith("0.1 0 0", "0,1 0 0"),
                          {"arm.urdf:6: j2: '0,1' is no number, in xyz=\"0,1 0 0\" of <origin> (numbers with blanks"}));
  EXPECT_TRUE(SaysInOrder(ErrorWith("0 1.57 0", "0 1.57"), {"arm.urdf:6: j2:", "2 numbers stand where 3 are"}));
  EXPECT_TRUE(SaysInOrder(ErrorWith("lower='-2'", "lower='-pi'"), {"arm.urdf:6: j2: '-pi' is no number", "<limit>"}));
  EXPECT_TRUE(SaysInOrder(ErrorWith("xyz='0 1 0'", "xyz='0 nan 0'"), {"arm.urdf:6: j2: 'nan' is no number", "<axis>"}));
  EXPECT_TRUE(SaysInOrder(ErrorWith("<link name='l1'/>",
                                    "<link name='l1'><inertial><mass value='1 kg'/>"
                                    "<inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>"
                                    "</inertial></link>"),
                          {"arm.urdf:2: l1: 'kg' is no number"}));
  EXPECT_EQ(ErrorWith("</robot>", "<gazebo><joint><origin xyz='a'/></joint></gazebo></robot>"), "");
}

// XML means a blank by a line's end within an attribute.
TEST(UrdfNumbers, LineEndsAndTabsSeparateThem) {
  for (const char* blanks : {"0.1\n 0\t0", "\t0.1 0\r\n0 ", "+0.1  0 0"}) {
    const Robot robot = ReadUrdfText(Replaced(kArm, "0.1 0 0", blanks), "arm.urdf");
    const Robot plain = ReadUrdfText(kArm, "arm.urdf");
    ASSERT_EQ(robot.chain.num_transforms(), plain.chain.num_transforms());
    for (int e = 0; e < robot.chain.num_transforms(); ++e)
      EXPECT_EQ(robot.chain.transforms[e].nominal, plain.chain.transforms[e].nominal) << e;
  }
  const std::string comment = "<!-- it's\n\"a\n-->";
  EXPECT_EQ(ErrorWith("<?xml version='1.0'?>\n", "<?xml version='1.0'?>\n" + comment), "");
}

TEST(UrdfNumbers, DegreesAndMillimetresAreRefused) {
  EXPECT_TRUE(SaysInOrder(ErrorWith("0 1.57 0", "0 90 0"),
                          {"arm.urdf:5: j2: pitch of its origin (rpy) is 90 rad", "angles are in rad here"}));
  EXPECT_TRUE(SaysInOrder(ErrorWith("lower='-2'", "lower='-120'"),
                          {"arm.urdf:5: j2: the joint has a limit of -120 rad", "120 deg are 2.0944"}));
  EXPECT_TRUE(SaysInOrder(ErrorWith("xyz='0.3 0 0'", "xyz='300 0 0'"),
                          {"arm.urdf:7: jt:", "the flange is", "no robot reaches", "lengths are in m here"}));
  const std::string hall = Replaced(Replaced(kArm, "<link name='base_link'/>",
                                             "<link name='w'/><link name='base_link'/><joint name='jw' type='fixed'>"
                                             "<parent link='w'/><child link='base_link'/><origin xyz='120 0 0'/>"
                                             "</joint>"),
                                    "xyz='0 0 0.4'", "xyz='0 0 0.5'");
  EXPECT_EQ(ErrorOf([&] { ReadUrdfText(hall, "arm.urdf"); }), "") << "where in a hall";
  const auto track = [&](const std::string& upper) {
    const std::string slides = Replaced(kArm, "name='j1' type='revolute'", "name='j1' type='prismatic'");
    return ErrorOf([&] { ReadUrdfText(Replaced(slides, "upper='3'", "upper='" + upper + "'"), "arm.urdf"); });
  };
  EXPECT_EQ(track("40"), "");
  EXPECT_TRUE(SaysInOrder(track("4000"), {"arm.urdf:3: j1:", "a limit of 4000 m"}));
  EXPECT_EQ(track("1e16"), "") << "writers that know none";
}

// Both would be added: the joint would move by their sum.
TEST_F(FileTest, RobotCouplingsAreStatedOnce) {
  Write("arm.urdf", Replaced(kArm, "<axis xyz='0 1 0'/>", "<axis xyz='0 1 0'/><mimic joint='j1' multiplier='0.5'/>"));
  const auto error = [&](const std::string& text) {
    return ErrorOf([&] { ReadRobotFile(Write("robot.yaml", "schema: sagitta/robot/1\n" + text)); });
  };
  const std::string urdf = "kinematics: {urdf: {file: arm.urdf}}\n";
  EXPECT_EQ(error(urdf), "");
  EXPECT_TRUE(SaysInOrder(error(urdf + "coupling: [{joint: j2, driver: j1, ratio: 1}]\n"),
                          {"robot.yaml:3", "'j1' drives 'j2' in the URDF already, by <mimic>"}));
  const std::string chain =
      "joints: [{name: j1, type: revolute}, {name: j2, type: revolute}, {name: j3, type: revolute}]\n"
      "kinematics: {chain: [{Rz: j1}, {Tx_mm: 100}, {Ry: j2}, {Tx_mm: 100}, {Ry: j3}]}\n";
  EXPECT_EQ(error(chain + "coupling: [{joint: j3, driver: j1, ratio: 1}, {joint: j3, driver: j2, ratio: 1}]\n"), "");
  EXPECT_TRUE(SaysInOrder(error(chain + "coupling:\n- {joint: j2, driver: j1, ratio: 1}\n"
                                        "- {joint: j2, driver: j1, ratio: -0.5}\n"),
                          {"robot.yaml:6", "'j1' drives 'j2' above already"}));
}

}  // namespace
}  // namespace sagitta::urdf_numbers_test
