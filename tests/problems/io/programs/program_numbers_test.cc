// Poses of robot programs as numbers: what each notation means, and how a rotation is written that has several sets.
#include <gtest/gtest.h>

#include "models/constants.h"
#include "tests/problems/io/programs/robot_program_test_support.h"

namespace sagitta::program_numbers_test {
namespace {

void ExpectRotation(const Matrix3<double>& actual, const Matrix3<double>& expected) {
  EXPECT_LT((actual - expected).norm(), 1e-12) << actual;
}

Matrix3<double> About(int axis, double degrees) {
  return Eigen::AngleAxisd(degrees * kDegree, Vector3<double>::Unit(axis)).toRotationMatrix();
}

// One step at a time, as the manuals say it.
TEST(PoseNotationTest, FollowsTheManuals) {
  // KRL: A about z, then B about the turned y, then C about the twice turned x.
  ExpectRotation(PoseFrom(PoseNotation::kAbcDegrees, {0, 0, 0, 30, 20, 10}).rotation,
                 About(2, 30) * About(1, 20) * About(0, 10));
  // FANUC: W about the fixed x, then P about the fixed y, then R about the fixed z.
  ExpectRotation(PoseFrom(PoseNotation::kWprDegrees, {0, 0, 0, 10, 20, 30}).rotation,
                 About(2, 30) * About(1, 20) * About(0, 10));
  // RAPID: 90 deg about z is [0.7071, 0, 0, 0.7071].
  ExpectRotation(PoseFrom(PoseNotation::kQuaternion, {0, 0, 0, std::sqrt(0.5), 0, 0, std::sqrt(0.5)}).rotation,
                 About(2, 90));
  ExpectRotation(PoseFrom(PoseNotation::kRotationVectorMetres, {0, 0, 0, 0, kPi / 3, 0}).rotation, About(1, 60));
  EXPECT_DOUBLE_EQ(PoseFrom(PoseNotation::kAbcDegrees, {1500, 0, 0, 0, 0, 0}).translation.x(), 1.5);
  EXPECT_DOUBLE_EQ(PoseFrom(PoseNotation::kRotationVectorMetres, {1.5, 0, 0, 0, 0, 0}).translation.x(), 1.5);
}

TEST(PoseNotationTest, WritesWhatItReads) {
  for (const PoseNotation notation : {PoseNotation::kAbcDegrees, PoseNotation::kWprDegrees, PoseNotation::kQuaternion,
                                      PoseNotation::kRotationVectorMetres}) {
    for (const double pitch : {20.0, 90.0, -90.0, 170.0}) {
      const Pose<double> pose{About(2, 100) * About(1, pitch) * About(0, -130), {0.1, -0.2, 0.3}};
      const Pose<double> back = PoseFrom(notation, NumbersOf(notation, pose));
      EXPECT_LT((back.rotation - pose.rotation).norm(), 1e-9) << static_cast<int>(notation) << " " << pitch;
      EXPECT_LT((back.translation - pose.translation).norm(), 1e-15);
    }
  }
}

using ProgramNumbersTest = RobotProgramTest;

TEST_F(ProgramNumbersTest, AnglesStayNearThoseOfTheFile) {
  const RobotProgram program = ReadAs("a.src", "LIN {X 0,Y 0,Z 0,A 180,B 89.99,C -180}\n");
  const Pose<double> same = PoseFrom(program.traits().notation, ValuesOf(program.points[0]));
  EXPECT_EQ(WithOne(program, 0, {}, &same),
            "LIN {X 0.0000,Y 0.0000,Z 0.0000,A 180.000000,B 89.990000,C -180.000000}\n");
}

// At a pitch of 90 deg only the difference of the other two angles is determined, at -90 deg their sum.
TEST_F(ProgramNumbersTest, AnglesStayThoseOfTheFileWhereTwoTurnAboutOneAxis) {
  for (const std::string pitch : {"90.000000", "-90.000000"}) {
    const std::string krl = "LIN {X 0.0000,Y 0.0000,Z 0.0000,A 30.000000,B " + pitch + ",C 200.000000}\n";
    const RobotProgram kuka = ReadAs("a.src", krl);
    const Pose<double> pose = PoseFrom(kuka.traits().notation, ValuesOf(kuka.points[0]));
    EXPECT_EQ(WithOne(kuka, 0, {}, &pose), krl);
    // The same rotation in FANUC's order: roll first.
    const std::string ls =
        "/PROG A\n/POS\nP[1]{\n GP1:\n UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n X = 0.0000 mm, "
        "Y = 0.0000 mm, Z = 0.0000 mm,\n W = 200.000000 deg, P = " +
        pitch + " deg, R = 30.000000 deg\n};\n/END\n";
    const RobotProgram fanuc = ReadAs("a.ls", ls);
    EXPECT_LT((PoseFrom(fanuc.traits().notation, ValuesOf(fanuc.points[0])).rotation - pose.rotation).norm(), 1e-12);
    EXPECT_EQ(WithOne(fanuc, 0, {}, &pose), ls);
  }
}

}  // namespace
}  // namespace sagitta::program_numbers_test
