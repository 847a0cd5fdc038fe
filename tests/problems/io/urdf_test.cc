#include <gtest/gtest.h>

#include "models/default_free_set.h"
#include "problems/io/robot_file.h"
#include "problems/io/urdf_robot.h"
#include "problems/io/urdf_writer.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/urdf_arms.h"

#ifdef SAGITTA_HAVE_KDL

namespace sagitta::urdf_test {
namespace {

using test::FlangeOf;
using test::UrdfRow;
using test::UrdfText;

struct Style {
  const char* name;
  std::vector<UrdfRow> rows;
};
void PrintTo(const Style& style, std::ostream* out) { *out << style.name; }

class UrdfStyle : public ::testing::TestWithParam<Style> {};

INSTANTIATE_TEST_SUITE_P(Styles, UrdfStyle,
                         ::testing::Values(Style{"Universal", test::UniversalStyle()},
                                           Style{"Industrial", test::IndustrialStyle()},
                                           Style{"Oblique", test::ObliqueStyle()}),
                         [](const auto& style) { return std::string(style.param.name); });

std::map<std::string, double> SmallErrors(const Chain& chain, double size) {
  test::RandomNumbers random(7);
  std::map<std::string, double> errors;
  for (const ElementaryTransform& transform : chain.transforms) {
    if (!transform.error.empty()) errors[transform.error] = random.Uniform(-size, size);
  }
  return errors;
}

TEST_P(UrdfStyle, FlangeIsThatOfKdl) {
  const Robot robot = ReadUrdfText(UrdfText(GetParam().rows), "arm.urdf");
  EXPECT_EQ(robot.name, "arm");
  test::ExpectSameFlange(robot.chain, test::KdlChainOfUrdf(GetParam().rows), 1e-9);
}

TEST_P(UrdfStyle, WrittenAnewItIsThatOfKdl) {
  const Robot robot = ReadUrdfText(UrdfText(GetParam().rows), "arm.urdf");
  const Robot again = ReadUrdfText(RobotToUrdf(robot), "new.urdf");
  test::ExpectSameFlange(again.chain, test::KdlChainOfUrdf(GetParam().rows), 1e-9);
  const Robot yaml = ReadRobotText(RobotToYaml(robot), "robot.yaml");
  test::ExpectSameFlange(yaml.chain, test::KdlChainOfUrdf(GetParam().rows), 1e-9);
}

// Names of joints that would make the writer's own links and joints stand twice.
TEST(UrdfWriterTest, LinksAndJointsHaveDifferentNames) {
  Robot robot = ReadUrdfText(UrdfText(test::UniversalStyle()), "arm.urdf");
  const Chain before = robot.chain;
  const char* names[] = {"base", "flange", "flange_joint", "base_link", "flange_joint_", "world"};
  for (size_t j = 0; j < robot.chain.joints.size(); ++j) robot.chain.joints[j].name = names[j];
  const Robot again = ReadUrdfText(RobotToUrdf(robot), "new.urdf");
  for (size_t j = 0; j < robot.chain.joints.size(); ++j) EXPECT_EQ(again.chain.joints[j].name, names[j]);
  const Eigen::VectorXd q = Eigen::VectorXd::LinSpaced(robot.num_joints(), -0.5, 0.7);
  EXPECT_LT((FlangeOf(again.chain, q).translation - FlangeOf(before, q).translation).norm(), 1e-12);
}

// Errors span every motion of the flange: of 4R + 2P + 6 parameters (Everett, Driels, Mooring 1987) base and tool have
// 12, also where a pitch of 90 degrees makes roll and yaw of rpy the same.
TEST_P(UrdfStyle, DefaultErrorsAreCompleteAndMinimal) {
  const Robot robot = ReadUrdfText(UrdfText(GetParam().rows), "arm.urdf");
  int expected = 6 - 12;
  for (const Joint& joint : robot.chain.joints) expected += joint.type == JointType::kRevolute ? 4 : 2;
  EXPECT_EQ(static_cast<int>(DefaultFreeSet(robot.chain).free.size()), expected);
}

TEST_P(UrdfStyle, CalibratedRobotGoesIntoTheOriginsOfItsUrdf) {
  const std::string text = UrdfText(GetParam().rows);
  const Robot robot = ReadUrdfText(text, "arm.urdf");
  const Robot calibrated = WithGeometricErrors(robot, SmallErrors(robot.chain, 2e-3));
  // Through the file that calibrate writes: a chain.
  const EditedUrdf edited = EditUrdf(text, "arm.urdf", {}, ReadRobotText(RobotToYaml(calibrated), "robot.yaml"));
  const Robot again = ReadUrdfText(edited.text, "edited.urdf");
  test::RandomNumbers random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::VectorXd q = test::RandomJointValues(robot.chain, &random);
    const Pose<double> expected = FlangeOf(calibrated.chain, q), found = FlangeOf(again.chain, q);
    ASSERT_LT((expected.translation - found.translation).norm(), 1e-9);
    ASSERT_LT((expected.rotation - found.rotation).norm(), 1e-9);
    ASSERT_GT((expected.translation - FlangeOf(robot.chain, q).translation).norm(), 1e-5);
  }
}

// Lines that differ hold an origin of a joint; none is lost.
TEST_P(UrdfStyle, EditsTouchOriginsOnly) {
  const std::string text = UrdfText(GetParam().rows);
  const Robot robot = ReadUrdfText(text, "arm.urdf");
  const Robot calibrated = WithGeometricErrors(robot, SmallErrors(robot.chain, 1e-3));
  const EditedUrdf edited = EditUrdf(text, "arm.urdf", {}, calibrated);
  EXPECT_EQ(static_cast<int>(edited.joints.size()), robot.num_joints());
  std::istringstream before(text), after(edited.text);
  std::string a, b;
  while (std::getline(before, a)) {
    ASSERT_TRUE(std::getline(after, b));
    if (a == b) continue;
    if (b.find("<origin xyz=") == std::string::npos || a.find("<origin xyz=") == std::string::npos) {
      EXPECT_EQ(b.substr(0, 11), "    <origin") << "a new origin, in a line of its own: " << b;
      ASSERT_TRUE(std::getline(after, b));
      EXPECT_EQ(a, b);
    }
  }
  EXPECT_FALSE(std::getline(after, b));
}

TEST_P(UrdfStyle, UnchangedRobotLeavesTheTextAsItIs) {
  const std::string text = UrdfText(GetParam().rows);
  const EditedUrdf edited = EditUrdf(text, "arm.urdf", {}, ReadUrdfText(text, "arm.urdf"));
  EXPECT_EQ(edited.text, text);
  EXPECT_TRUE(edited.joints.empty());
}

// A robot described otherwise (a chain without the URDF's names): the frames of the URDF move onto its axes.
TEST(UrdfEditTest, ForeignChainOfTheSameArm) {
  const std::string text = UrdfText(test::IndustrialStyle());
  Robot robot = ReadUrdfText(text, "arm.urdf");
  robot = WithGeometricErrors(robot, SmallErrors(robot.chain, 1e-3));
  for (ElementaryTransform& transform : robot.chain.transforms) transform.error.clear();
  const Robot again = ReadUrdfText(EditUrdf(text, "arm.urdf", {}, robot).text, "edited.urdf");
  test::RandomNumbers random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::VectorXd q = test::RandomJointValues(robot.chain, &random);
    ASSERT_LT((FlangeOf(robot.chain, q).translation - FlangeOf(again.chain, q).translation).norm(), 1e-9);
    ASSERT_LT((FlangeOf(robot.chain, q).rotation - FlangeOf(again.chain, q).rotation).norm(), 1e-9);
  }
}

TEST(UrdfEditTest, AnotherRobotIsRefused) {
  auto rows = test::IndustrialStyle();
  const std::string text = UrdfText(rows);
  rows[3].x += 0.2;
  const Robot longer = ReadUrdfText(UrdfText(rows), "longer.urdf");
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { EditUrdf(text, "arm.urdf", {}, longer); }),
                          {"arm.urdf", "a3", "200 mm", "another robot"}));
}

// Each would move another joint than the one that was calibrated.
TEST(UrdfEditTest, WhatTheUrdfCannotHoldIsRefused) {
  const auto rows = test::UniversalStyle();
  const std::string text = UrdfText(rows);
  const Robot robot = ReadUrdfText(text, "arm.urdf");
  const auto refusal = [](const std::string& urdf, const Robot& into, const UrdfEnds& ends = {}) {
    return ErrorOf([&] { EditUrdf(urdf, "arm.urdf", ends, into); });
  };
  const UrdfEnds upward = {"l7", "l0"};
  EXPECT_TRUE(SaysInOrder(refusal(text, robot, upward), {"arm.urdf", "from child to parent", "towards the tip"}));
  EXPECT_TRUE(SaysInOrder(refusal(text, robot, {"l0", "l3"}), {"has 3 joints, the robot has 6", "--tip_link"}));
  Robot slides = robot;
  slides.chain.joints[1].type = JointType::kPrismatic;
  EXPECT_TRUE(SaysInOrder(refusal(text, slides), {"lift", "is of the other type"}));

  const auto mimic = [&](const std::string& multiplier) {
    return Replaced(text, "<!-- joint 2 -->", "<mimic joint=\"lift\" multiplier=\"" + multiplier + "\"/>");
  };
  const Robot coupled = ReadUrdfText(mimic("-0.5"), "arm.urdf");
  EXPECT_EQ(refusal(mimic("-0.5"), coupled), "");
  EXPECT_TRUE(SaysInOrder(refusal(mimic("-0.4"), coupled), {"elbow", "another coupling", "<mimic>"}));
  EXPECT_TRUE(SaysInOrder(refusal(text, coupled), {"couplings that this URDF does not have", "<mimic>"}));
  EXPECT_TRUE(SaysInOrder(refusal(Replaced(text, "</robot>", ""), robot), {"arm.urdf"}));
}

// Against the direction of the tree: the chain from the tip to the base is the inverse pose.
TEST(UrdfReadTest, ChainRunsUpTheTreeToo) {
  const std::string text = UrdfText(test::ObliqueStyle());
  const Robot down = ReadUrdfText(text, "arm.urdf"), up = ReadUrdfText(text, "arm.urdf", {"l9", "l0"});
  test::RandomNumbers random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::VectorXd q = test::RandomJointValues(down.chain, &random);
    const Pose<double> there = FlangeOf(down.chain, q), back = FlangeOf(up.chain, q.reverse());
    EXPECT_LT((there.rotation * back.rotation - Matrix3<double>::Identity()).norm(), 1e-12);
    EXPECT_LT((there * back.translation).norm(), 1e-12);
  }
  EXPECT_EQ(DefaultFreeSet(up.chain).free.size(), DefaultFreeSet(down.chain).free.size());
}

// j3 follows j2: KDL gets the sum by hand.
TEST(UrdfReadTest, MimicIsACoupling) {
  auto rows = test::UniversalStyle();
  std::string text = UrdfText(rows);
  text = Replaced(text, "<!-- joint 2 -->", "<mimic joint=\"lift\" multiplier=\"-0.5\" offset=\"0.3\"/>");
  const Robot robot = ReadUrdfText(text, "arm.urdf");
  ASSERT_EQ(robot.chain.couplings.size(), 1u);
  const KDL::Chain kdl = test::KdlChainOfUrdf(rows);
  test::RandomNumbers random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::VectorXd q = test::RandomJointValues(robot.chain, &random);
    Eigen::VectorXd kdl_q = q;
    kdl_q[2] += -0.5 * q[1] + 0.3;
    const KDL::Frame expected = test::KdlFlange(kdl, kdl_q);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(FlangeOf(robot.chain, q).translation[i], expected.p[i], 1e-9);
  }
  // It has no motor: by itself it does not move, whatever limits the URDF states.
  EXPECT_TRUE(robot.chain.joints[2].IsHeld());
  EXPECT_EQ(robot.chain.num_driven(), 5);
  const Robot anew = ReadUrdfText(RobotToUrdf(robot), "anew.urdf"),
              yaml = ReadRobotText(RobotToYaml(robot), "robot.yaml");
  for (const Robot* other : {&anew, &yaml}) {
    EXPECT_EQ(other->chain.num_driven(), 5);
    const Eigen::VectorXd q = Eigen::VectorXd::LinSpaced(6, -1.0, 1.0).cwiseProduct(Eigen::VectorXd::Unit(6, 1));
    const Pose<double> expected = FlangeOf(robot.chain, q), found = FlangeOf(other->chain, q);
    EXPECT_LT((found.translation - expected.translation).norm(), 1e-9);
    EXPECT_LT((found.rotation - expected.rotation).norm(), 1e-9);
  }
  // Errors go into the origins, the mimic's offset stays where it is.
  const Robot calibrated = WithGeometricErrors(robot, SmallErrors(robot.chain, 1e-3));
  const Robot again = ReadUrdfText(EditUrdf(text, "arm.urdf", {}, calibrated).text, "edited.urdf");
  const Eigen::VectorXd q = test::RandomJointValues(robot.chain, &random);
  EXPECT_LT((FlangeOf(calibrated.chain, q).translation - FlangeOf(again.chain, q).translation).norm(), 1e-12);
}

TEST(UrdfReadTest, MimicsThatCannotBeACouplingAreRefused) {
  const std::string text = UrdfText(test::UniversalStyle());
  const auto with = [&](const std::string& mimic) {
    return ErrorOf([&] { ReadUrdfText(Replaced(text, "<!-- joint 2 -->", mimic), "arm.urdf"); });
  };
  EXPECT_TRUE(SaysInOrder(with("<mimic joint=\"elbow\"/>"), {"arm.urdf", "elbow", "the joint itself"}));
  EXPECT_TRUE(SaysInOrder(with("<mimic joint=\"gripper\"/>"), {"arm.urdf", "elbow", "not between 'l0' and 'l7'"}));
}

TEST(UrdfWriteTest, WhatMimicCannotStateIsRefused) {
  Robot robot = ReadUrdfText(UrdfText(test::UniversalStyle()), "arm.urdf");
  const auto words = [&] { return ErrorOf([&] { RobotToUrdf(robot); }); };
  robot.chain.couplings = {{2, 1, 0.5}};
  EXPECT_TRUE(SaysInOrder(words(), {"elbow", "moves by itself and with another", "0 and 0"}));
  robot.chain.joints[2].min = robot.chain.joints[2].max = 0.1;
  EXPECT_TRUE(SaysInOrder(words(), {"elbow", "moves by itself and with another"}));
  robot.chain.joints[2].min = robot.chain.joints[2].max = 0.0;
  EXPECT_EQ(words(), "");
  robot.chain.couplings.push_back({2, 0, 0.5});
  EXPECT_TRUE(SaysInOrder(words(), {"elbow", "moves with two others"}));
  robot.chain.couplings.clear();
  EXPECT_TRUE(SaysInOrder(words(), {"elbow", "is held"}));
}

TEST_F(FileTest, RobotFileNamesItsUrdf) {
  Write("arm.urdf", UrdfText(test::IndustrialStyle()));
  const std::string yaml = "schema: sagitta/robot/1\nname: mine\nkinematics:\n  urdf: {file: arm.urdf}\n";
  const Robot robot = ReadRobotFile(Write("robot.yaml", yaml));
  EXPECT_EQ(robot.name, "mine");
  EXPECT_EQ(robot.num_joints(), 6);
  EXPECT_NEAR(robot.chain.joints[0].max.value(), 3.0, 1e-15);
  EXPECT_GE(robot.chain.FindError("a4.roll"), 0);
  EXPECT_EQ(ReadRobotFile(Path("arm.urdf")).num_joints(), 6);
  const auto error_of = [&](const std::string& from, const std::string& to) {
    return ErrorOf([&] { ReadRobotFile(Write("robot.yaml", Replaced(yaml, from, to))); });
  };
  EXPECT_TRUE(
      SaysInOrder(error_of("arm.urdf", "none.urdf"), {"robot.yaml:4: kinematics.urdf.file", "no file", "none.urdf"}));
  EXPECT_TRUE(SaysInOrder(error_of("arm.urdf}", "arm.urdf, tip_link: l77}"), {"tip_link", "no link 'l77'", "l0, l1"}));
  EXPECT_TRUE(SaysInOrder(error_of("kinematics", "joints: [{name: q, type: revolute}]\nkinematics"),
                          {"robot.yaml:3", "joints", "not the joints of the URDF", "a1, a2"}));
}

TEST(UrdfReadTest, SeveralTipsAreListed) {
  std::string text = UrdfText(test::UniversalStyle());
  const std::string sensor =
      "<link name=\"ft\"/><joint name=\"ftj\" type=\"fixed\"><parent link=\"l6\"/><child link=\"ft\"/></joint>";
  const std::string camera =
      "<link name=\"cam\"/><joint name=\"cj\" type=\"fixed\"><parent link=\"l2\"/><child link=\"cam\"/></joint>";
  // A camera on the upper arm lies on the way: no other end of the chain.
  EXPECT_EQ(ReadUrdfText(Replaced(text, "</robot>", camera + "</robot>"), "arm.urdf").num_joints(), 6);
  text = Replaced(text, "</robot>", sensor + "</robot>");
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadUrdfText(text, "arm.urdf"); }),
                          {"arm.urdf", "tip_link", "beyond 'l0'", "l7 (6 joints)", "ft (6 joints)"}));
  EXPECT_EQ(ReadUrdfText(text, "arm.urdf", {"", "ft"}).num_joints(), 6);
}

TEST(UrdfReadTest, BadFilesAreRefusedInWords) {
  const std::string text = UrdfText(test::UniversalStyle());
  const auto error_of = [&](const std::string& from, const std::string& to) {
    ::testing::internal::CaptureStderr();
    const std::string error = ErrorOf([&] { ReadUrdfText(Replaced(text, from, to), "arm.urdf"); });
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "") << "the library prints nothing";
    return error;
  };
  EXPECT_TRUE(SaysInOrder(error_of("</robot>", ""), {"arm.urdf", "not a valid URDF"}));
  EXPECT_TRUE(SaysInOrder(error_of("<robot", "<xacro:include/><robot"), {"arm.urdf", "xacro"}));
  EXPECT_TRUE(
      SaysInOrder(error_of("type=\"revolute\"", "type=\"floating\""), {"arm.urdf", "pan", "floating or planar"}));
  EXPECT_TRUE(SaysInOrder(error_of("axis xyz=\"0 0 1\"", "axis xyz=\"0 0 0\""), {"arm.urdf", "pan", "no direction"}));
  EXPECT_TRUE(SaysInOrder(error_of("<child link=\"l3\"", "<child link=\"nowhere\""), {"not a valid URDF", "nowhere"}));
}

TEST(RpyTest, IsTheInverseAtEveryPitch) {
  test::RandomNumbers random(11);
  for (int trial = 0; trial < 300; ++trial) {
    Vector3<double> rpy(random.Uniform(-kPi, kPi), random.Uniform(-1.5, 1.5), random.Uniform(-kPi, kPi));
    if (trial % 3 == 0) rpy.y() = (trial % 2 ? 1 : -1) * (0.5 * kPi - (trial % 5) * 1e-13);
    const Matrix3<double> rotation = RotationFromRpy(rpy);
    EXPECT_LT((RotationFromRpy(RpyFromRotation(rotation)) - rotation).norm(), 3e-15);
  }
}

}  // namespace
}  // namespace sagitta::urdf_test

#else

TEST(Urdf, FlangeIsThatOfKdl) {
  GTEST_SKIP() << "liborocos-kdl-dev is not installed: no independent forward kinematics";
}

#endif
