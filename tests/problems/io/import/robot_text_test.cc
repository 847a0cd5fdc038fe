// MATLAB text, elementary transforms and a controller's lists: what is read has its unit, what is not is refused.
#include <gtest/gtest.h>

#include "models/constants.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/robot_reading.h"
#include "problems/text.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::robot_text_test {
namespace {

class RobotText : public FileTest {
 protected:
  RobotReading Read(const std::string& text, const RobotReadOptions& options = {}) const {
    return ReadAnyRobot(Write("file.txt", text), options);
  }
  std::string Error(const std::string& text, const RobotReadOptions& options = {}) const {
    return ErrorOf([&] { Read(text, options); });
  }
  // Of the transform that the second joint moves, deg.
  double SecondOffset(const std::string& text) const {
    const Chain chain = Read(text).robot.chain;
    return chain.transforms[chain.JointTransform(1)].nominal / kDegree;
  }
};
class RobotTransforms : public RobotText {};
class MatlabLinks : public RobotText {};
class RobotUnits : public RobotText {};

// Offsets of joints say the unit as other angles do.
TEST_F(RobotTransforms, OffsetsOfJointsAreInTheUnitOfTheAngles) {
  for (const char* second : {"Ry(q2-90)", "Ry(q2 - 90 deg)", "Ry(-90+q2)"}) {
    const std::string text = std::string("Tz(0.4) Rz(q1) Tx(0.1) ") + second + " Tx(0.5) Ry(q3)";
    EXPECT_NEAR(SecondOffset(text), -90.0, 1e-9) << text;
  }
  EXPECT_NEAR(SecondOffset("Tz(0.4) Rz(q1) Tx(0.1) Ry(90-q2) Tx(0.3) Ry(q3)"), 90.0, 1e-9);
  EXPECT_NEAR(SecondOffset("Tz(0.4) Rz(q1) Ry(q2-1.5) Rx(0.3)"), -1.5 / kDegree, 1e-9);
  EXPECT_EQ(Read("Tz(0.4) Rz(q1) Ry(q2-1.5) Rx(0.3)").guesses.size(), 1u);
}

TEST_F(RobotTransforms, WithPiIsRadAndBeyondAFullTurnIsDeg) {
  const RobotReading reading = Read("Rz(q1) Tx(0.1) Ry(q2+pi/2) Rx(90) Tz(0.3)");
  EXPECT_NEAR(reading.robot.chain.transforms[2].nominal, 0.5 * kPi, 1e-15);
  EXPECT_NEAR(reading.robot.chain.transforms[3].nominal, 0.5 * kPi, 1e-15);
  EXPECT_TRUE(reading.guesses.empty());
  ASSERT_EQ(reading.notes.size(), 1u);
  EXPECT_NE(reading.notes[0].find("with pi are in rad"), std::string::npos);
  EXPECT_TRUE(SaysInOrder(Error("Rz(q1) Tx(0.1)\nRy(q2+pi/2) Rx(90) Rz(1.5)"),
                          {"file.txt:2", "Rz(1.5)", "may be in deg or in rad"}));
  EXPECT_TRUE(SaysInOrder(Error("Rz(q1) Tx(0.3) Rx(1.57) Ry(q2+90)"), {"Rx(1.57)", "may be in deg or in rad"}));
  EXPECT_EQ(Error("Rz(q1) Tx(0.3) Rx(1.3) Ry(q2+90)"), "") << "a calibrated angle in deg";
}

TEST_F(RobotTransforms, NothingIsLeftOut) {
  const std::pair<const char*, const char*> cases[] = {
      {"Tz(0.4) Rz(q1)\nTxyz(0.1,0,0.2) Ry(q2)", "file.txt:2: 'Txyz(0.1,0,0.2)' is not understood"},
      {"Tz(0.4) * Rz(q1) * trans(0.5,0,0) * Ry(q2)", "file.txt:1: 'trans(0.5,0,0)' is not understood"},
      {"Tz(0.4) * Rz(q1) * T(0.1) * Ry(q2)", "'T(0.1)' is not understood"},
      {"Rz(q1) Ry(q2) Tx(0.3)\nT(0.1)", "file.txt:2: 'T(0.1)' is not understood"},
      {"rotRx(0.1) Rz(q1)", "'rot' is not understood"},
      {"Rz(q1) inv(Tx(0.3)) Ry(q2)", "'inv(' is not understood"},
      {"Rz(q1) Tx(0.3)' Ry(q2)", "''' is not understood"},
      {"E = Rz(q1) Tx(0.3);\nF = Ry(q2) Tx(1)", "file.txt:2: 'F = …' is a second sequence"}};
  for (const auto& [text, words] : cases) EXPECT_TRUE(SaysInOrder(Error(text), {words})) << text;
}

TEST_F(RobotTransforms, SeparatorsCommentsAndAssignmentsAreNone) {
  const char* texts[] = {"% an arm\nE = Tz(0.4) * Rz(q1) * ... # up\n  Tx(0.1).Ry(q2), Tx(0.3);\n",
                         "clear all;\ns = 'Tz(0.4) Rz(q1) Tx(0.1) Ry(q2) Tx(0.3)';\ndh = DHFactor(s);\n",
                         "dh = DHFactor('Tz(0.4) Rz(q1) Tx(0.1) Ry(q2) Tx(0.3)')",
                         "E = ET.tz(0.4) * ET.rz(q1)\nE = E * ET.tx(0.1) * ET.ry(q2)\nE *= ET.tx(0.3)\n",
                         "Tz(0.4) · Rz(q1) × Tx(0.1)\nRy(q2)\r\nTx(0.3)"};
  for (const char* text : texts) EXPECT_EQ(Read(text).robot.chain.num_transforms(), 5) << text;
}

TEST_F(RobotTransforms, AJointStandsInOneTransform) {
  EXPECT_TRUE(SaysInOrder(Error("Tz(0.4) Rz(q1) Tx(0.1)\nRy(q1) Tx(0.3) Ry(q2)"),
                          {"file.txt:2", "joint 1 moves two transforms", "Rz(q1)", "Ry(q1)"}));
  EXPECT_TRUE(SaysInOrder(Error("Tz(90 deg) Rz(q1)"), {"Tz(90 deg)", "a length"}));
}

TEST(RobotExpressions, AProductIsNoLongerNumber) {
  EXPECT_FALSE(ParseTypedNumber("2*3"));
  EXPECT_FALSE(ParseJointExpression("q2*90"));
  EXPECT_FALSE(ParseJointExpression("q2 90"));
  EXPECT_TRUE(ParseJointExpression("q2*"));
  EXPECT_TRUE(ParseTypedNumber("0.5*pi"));
}

const char kLinks[] = "L(1) = Link([0 0.4 0 pi/2]);\nL(2) = Link([0 0 0.5 0]);\nL(3) = Link([0 0 0.1 -pi/2 1]);\n";

TEST_F(MatlabLinks, OffsetsThatAreAssignedCount) {
  const auto links = [&](const std::string& more) { return Read(kLinks + more).robot.dh->links; };
  EXPECT_NEAR(links("L(2).offset = -pi/2;\n")[1].theta, -0.5 * kPi, 1e-15);
  EXPECT_NEAR(links("L(3).offset = 0.2;\n")[2].d, 0.2, 1e-15);
  const auto all = links("R = SerialLink(L);\nR.offset = [0.1 -pi/2 0.2];\n");
  EXPECT_NEAR(all[0].theta, 0.1, 1e-15);
  EXPECT_NEAR(all[1].theta, -0.5 * kPi, 1e-15);
  EXPECT_NEAR(all[2].d, 0.2, 1e-15);
  // The later one replaces the earlier.
  EXPECT_NEAR(links("L(2).offset = 1;\nL(2).offset = 0.5;\n")[1].theta, 0.5, 1e-15);
  EXPECT_NEAR(
      Read("L1 = Link([0 0.4 0 pi/2]);\nL2 = Link([0 0 0.5 0 0 1]);\nL2.offset = 0.5;\n").robot.dh->links[1].theta, 0.5,
      1e-15);
  EXPECT_NEAR(
      Read("R = SerialLink([0 0.4 0 pi/2; 0 0 0.5 0], 'modified');\nR.offset = [0 -pi/2];").robot.dh->links[1].theta,
      -0.5 * kPi, 1e-15);
}

TEST_F(MatlabLinks, WhatChangesTheRobotOtherwiseIsRefused) {
  const std::pair<const char*, const char*> cases[] = {
      {"R.offset = [0 -pi/2];", "file.txt:4: 'R.offset = [0 -pi/2]' is not understood"},
      {"L(2).offset = deg2rad(90);", "file.txt:4: 'deg2rad(90)' has no value"},
      {"R.base = transl(0,0,0.5);", "file.txt:4: 'R.base = transl(0,0,0.5)' is not read"},
      {"R.tool = transl(0,0,0.2);", "file.txt:4: 'R.tool = transl(0,0,0.2)' is not read"},
      {"R.base.t = [0 0 1];", "is not read"},
      {"R = SerialLink(L, 'tool', T);", "is not read"},
      {"L(2).alpha = pi/2;", "changes the table"},
      {"L(4) = Link('d', 0.4, 'a', 0);", "is a link that is not read"},
      {"L(4) = Revolute('d', 0.4);", "is a link that is not read"},
      {"R = SerialLink([0 0 0 0]);", "a second table"}};
  for (const auto& [line, words] : cases) EXPECT_TRUE(SaysInOrder(Error(std::string(kLinks) + line), {words})) << line;
  for (const char* line : {"R.base = eye(4);", "R.tool = transl(0, 0, 0);", "R.name = 'x';", "L(1).m = 3;"})
    EXPECT_EQ(Error(std::string(kLinks) + line), "") << line;
  EXPECT_TRUE(SaysInOrder(Error("L1 = Link([0 0.4 0 0]);\n%L2 = Link([0 0 1 0]);\nL3 = Link([0 0 0.5 0]);\n"),
                          {"file.txt:3", "link 3 stands where link 2"}));
  EXPECT_TRUE(SaysInOrder(Error("dhparams = [0 1 0 0; 0.4 0 0 0];\ndhparams(:,2) = dhparams(:,2)*2;\n"),
                          {"file.txt:2", "changes the table"}));
  EXPECT_TRUE(SaysInOrder(Error("dhparams = [0 1 0 0; 0.4 0 0 0]*2;\n"), {"file.txt:1", "behind the table", "*2"}));
  const RobotReading limited = Read(std::string(kLinks) + "L(1).qlim = [-1 1];");
  ASSERT_FALSE(limited.notes.empty());
  EXPECT_NE(limited.notes[0].find("limits are not read: L(1).qlim"), std::string::npos);
}

// Of a rigidBodyTree the joints say whether they turn, and setFixedTransform which row is whose.
TEST_F(MatlabLinks, JointsOfATreeTurnOrSlide) {
  const std::string table = "dhparams = [0 pi/2 0.4 0; 0.3 0 0 0; 0.25 0 0 0];\n",
                    first = "j1 = rigidBodyJoint(['j' num2str(1)],'revolute');\n",
                    third = "j3 = rigidBodyJoint('j3', \"prismatic\");\n",
                    row = "setFixedTransform(j3,dhparams(3,:),'dh');\n";
  const auto types = [&](const std::string& text) {
    std::vector<JointType> found;
    for (const Joint& joint : Read(text).robot.chain.joints) found.push_back(joint.type);
    return found;
  };
  const JointType turns = JointType::kRevolute, slides = JointType::kPrismatic;
  EXPECT_EQ(types(table + first), (std::vector<JointType>{turns, turns, turns}));
  EXPECT_EQ(types(table + first + third + row), (std::vector<JointType>{turns, turns, slides}));
  EXPECT_EQ(types(table + "j = robotics.Joint('a','prismatic');\nsetFixedTransform(j, dhparams(1, :), 'dh');\n"
                          "j = robotics.Joint('b','revolute');\nsetFixedTransform(j, dhparams(2, :), 'dh');\n"),
            (std::vector<JointType>{slides, turns, turns}));
  const std::pair<std::string, const char*> cases[] = {
      {third, "file.txt:2: 'j3 = rigidBodyJoint('j3', \"prismatic\")' slides, and which row of dhparams"},
      {third + "setFixedTransform(j3,dhparams(k,:),'dh');\n", "slides, and which row"},
      {third + "setFixedTransform(j3,dhparams(4,:),'dh');\n", "slides, and which row"},
      {third + "j3 = rigidBodyJoint('b','revolute');\n" + row, "slides, and which row"},
      {"e = rigidBodyJoint('e','fixed');\n", "does not move"},
      {"e = rigidBodyJoint('e');\n", "whether the joint turns or slides"},
      {"e = rigidBodyJoint('e', kinds{1});\n", "whether the joint turns or slides"}};
  for (const auto& [text, words] : cases) EXPECT_TRUE(SaysInOrder(Error(table + text), {words})) << text;
}

// What setFixedTransform ignores is an offset here: that is a guess, and said.
TEST_F(MatlabLinks, WhatATreeIgnoresIsSaid) {
  const std::string head = "dhparams = [0 pi/2 0.4 -1; 0.3 0 0 0];\nj = rigidBodyJoint('a','revolute');\n";
  const RobotReading reading = Read(head + "setFixedTransform(j,dhparams(1,:),'dh');\n");
  ASSERT_EQ(reading.guesses.size(), 1U);
  EXPECT_NE(reading.guesses[0].find("theta of row 1 adds to its joint's value"), std::string::npos);
  EXPECT_EQ(Read(head + "setFixedTransform(j,dhparams(1,:),'mdh');\n").guesses.size(), 0U);
}

// Degrees and millimetres where the format prescribes rad and m.
TEST_F(RobotUnits, NumbersThatCannotBeInMOrRadAreRefused) {
  const std::pair<const char*, const char*> cases[] = {
      {"R = SerialLink([0 0.4 0 90; 0 0 0.5 0]);", "alpha is 90 rad, more than a full turn (angles are in rad here"},
      {"R = SerialLink([0 400 0 pi/2; 0 0 500 0]);", "a is 500 m, which no link is long (lengths are in m here"},
      {"R = SerialLink([0 340 0 pi/2; 0 0 0 -pi/2; 0 400 0 0]);", "no robot reaches"},
      {"R = SerialLink([0 0.4 0 pi/2; 0 0 0.5 0 0 90]);", "theta is 90 rad"},
      {"dhparams = [0 90 400 0; 425 0 0 0; 392 0 0 0];", "alpha is 90 rad"}};
  for (const auto& [text, words] : cases) EXPECT_TRUE(SaysInOrder(Error(text), {"file.txt:1", words})) << text;
  const std::string a = "[DH]\na = [0, -0.425, -0.39225, 0, 0, 0]\n", d = "d = [0.089, 0, 0, 0.109, 0.0946, 0.082]\n",
                    alpha = "alpha = [1.5708, 0, 0, 1.5708, -1.5708, 0]\n";
  EXPECT_EQ(Error(a + d + alpha), "");
  EXPECT_TRUE(SaysInOrder(Error("[DH]\na = [0, -425, -392, 0, 0, 0]\n" + d + alpha), {"a:", "-425 m"}));
  EXPECT_TRUE(SaysInOrder(Error(a + "d = [89.159, 0, 0, 109, 95, 82]\n" + alpha), {"d:", "89.159 m"}));
  EXPECT_TRUE(SaysInOrder(Error(a + d + "alpha = [90, 0, 0, 90, -90, 0]\n"), {"alpha:", "90 rad"}));
}

// The RX-90 by Khalil and Dombre (Modeling, Identification and Control of Robots, 2002): d along x, r along z.
TEST_F(RobotUnits, KhalilsLengths) {
  const std::string rows =
      "j,sigma,alpha_deg,d_mm,theta_deg,r_mm\n1,0,0,0,0,0\n2,0,90,0,0,0\n3,0,0,450,0,0\n4,0,-90,0,0,450\n5,0,90,0,0,0\n"
      "6,0,-90,0,0,85\n";
  const RobotReading reading = Read("# RX-90, modified DH (Khalil)\n" + rows);
  EXPECT_EQ(reading.robot.dh->convention, DhConvention::kModified);
  EXPECT_EQ(reading.robot.dh->links[2].a, 0.45);
  EXPECT_EQ(reading.robot.dh->links[3].d, 0.45);
  EXPECT_EQ(reading.robot.dh->links[3].a, 0.0);
  EXPECT_TRUE(SaysInOrder(Joined(reading.notes), {"d is along x", "r along z"}));
  EXPECT_TRUE(SaysInOrder(Error("# modified DH\n" + rows), {"r", "along x", "Khalil", "along z", "call the length"}));
  EXPECT_EQ(Read("# standard DH\n" + rows).robot.dh->links[3].a, 0.45);
}

// His notation is a modified one: a standard table has r along x, whoever made the robot.
TEST_F(RobotUnits, AStandardTableIsNotKhalils) {
  const std::string rows = "joint,theta_deg,d_mm,r_mm,alpha_deg\n1,0,400,25,-90\n2,0,0,450,0\n3,0,0,35,-90\n";
  RobotReadOptions standard, modified;
  standard.convention = DhConvention::kStandard;
  modified.convention = DhConvention::kModified;
  const auto expect_standard = [](const RobotReading& reading) {
    EXPECT_EQ(reading.robot.dh->convention, DhConvention::kStandard);
    EXPECT_EQ(reading.robot.dh->links[0].a, 0.025);
    EXPECT_EQ(reading.robot.dh->links[0].d, 0.4);
  };
  for (const std::string head : {"# name: Khalil arm\n# standard DH\n", "# not after Khalil: standard DH\n"}) {
    expect_standard(Read(head + rows));
    expect_standard(Read(head + rows, standard));
  }
  expect_standard(Read("# name: Khalil arm\n" + rows, standard));
  EXPECT_TRUE(SaysInOrder(Error("# name: Khalil arm\n" + rows, modified), {"r", "is not said"}));
  const std::string both = "# Khalil and Dombre, in standard DH\n";
  EXPECT_TRUE(SaysInOrder(Error(both + rows), {"file.txt:2", "Khalil", "modified", "the file says standard"}));
  EXPECT_TRUE(SaysInOrder(Error(both + rows, modified), {"Khalil", "the file says standard"}));
  EXPECT_TRUE(SaysInOrder(Error("# Khalil\n" + rows, standard), {"Khalil", "--convention says standard"}));
  EXPECT_EQ(Read("# Khalil\n" + rows, modified).robot.dh->links[0].a, 0.4);
}

// Link and SerialLink put q where theta of a row that turns stands (Corke, Link.A).
TEST_F(MatlabLinks, ThetaThatTheToolboxIgnoresIsSaid) {
  const RobotReading reading = Read("R = SerialLink([pi/2 0.4 0 pi/2; 0 0 0.5 0; 0.1 0.2 0 0 1]);");
  EXPECT_TRUE(SaysInOrder(Joined(reading.guesses, "; "),
                          {"SerialLink; theta of row 1", "the toolbox ignores it", "; d of row 3"}));
  EXPECT_EQ(reading.guesses.size(), 3u);
}

}  // namespace
}  // namespace sagitta::robot_text_test
