// Target files of compensate: what they state arrives in SI, and what cannot be is refused with line and column.
#include "problems/io/target_file.h"

#include <gtest/gtest.h>

#include "models/constants.h"
#include "models/effects/effect.h"
#include "problems/text.h"
#include "tests/problems/file_test_support.h"
#include "tests/support/kr270.h"

namespace sagitta::target_file_test {
namespace {

Robot Arm() {
  Robot robot;
  robot.chain = test::Kr270Chain();
  return robot;
}

Targets Read(const std::string& text) { return TargetsFromTable(ParseCsvTable(text, "t.csv"), Arm(), "S1"); }

TEST(TargetFileTest, EverythingArrivesInSi) {
  const Targets targets = Read(
      "target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_m,y_mm,z_mm,rx_mrad,ry_deg,rz_rad,station,load,fz_N,my_Nm,"
      "time_s,"
      "temperature_degC,approach2,remark\n"
      "a,90,0,0,0,0,180,,,,,,,,,,,,,,first\n"
      "b,,,,,,,1.5,200,-30,0,0,1,S2,piece,-98,4,30,21.5,-1,second\n");
  ASSERT_EQ(targets.rows.size(), 2u);
  EXPECT_NEAR((*targets.rows[0].q)[0], M_PI / 2, 1e-15);
  EXPECT_NEAR((*targets.rows[0].q)[5], M_PI, 1e-15);
  EXPECT_FALSE(targets.rows[0].flange_in_base);
  EXPECT_FALSE(targets.rows[1].q);
  const Pose<double>& flange_in_base = *targets.rows[1].flange_in_base;
  EXPECT_LT((flange_in_base.translation - Vector3<double>(1.5, 0.2, -0.03)).norm(), 1e-15);
  EXPECT_NEAR(flange_in_base.rotation(0, 0), std::cos(1.0), 1e-15);
  EXPECT_NEAR(flange_in_base.rotation(1, 0), std::sin(1.0), 1e-15);
  ASSERT_EQ(targets.shots.shots.size(), 2u);
  const Shot &first = targets.shots.shots[0], &second = targets.shots.shots[1];
  EXPECT_EQ(targets.shots.stations, (std::vector<std::string>{"S1", "S2"}));
  EXPECT_EQ(first.station, 0);
  EXPECT_EQ(second.station, 1);
  EXPECT_FALSE(first.has_time || first.has_temperature);
  EXPECT_TRUE(first.approach.empty());
  EXPECT_EQ(second.load, "piece");
  EXPECT_EQ(second.wrench.force[2], -98);
  EXPECT_EQ(second.wrench.moment[1], 4);
  EXPECT_TRUE(second.has_time && second.has_temperature);
  EXPECT_EQ(second.time, 30);
  EXPECT_EQ(second.approach[1], -1);
  EXPECT_EQ(second.approach[0], kApproachNotStated);
}

// The same rotation in every form, its matrix from sines and cosines.
TEST(TargetFileTest, RotationsInFiveForms) {
  const double a = 0.7, b = -0.4, c = 2.1;
  Matrix3<double> about_z, about_y, about_x;
  about_z << std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1;
  about_y << std::cos(b), 0, std::sin(b), 0, 1, 0, -std::sin(b), 0, std::cos(b);
  about_x << 1, 0, 0, 0, std::cos(c), -std::sin(c), 0, std::sin(c), std::cos(c);
  const Matrix3<double> right = about_z * about_y * about_x;
  const Eigen::Quaterniond q(right);
  const Eigen::AngleAxisd turn(right);
  const Vector3<double> vector = turn.angle() * turn.axis();
  const auto row = [](const std::vector<double>& numbers) {
    std::string text;
    for (const double number : numbers) text += "," + FormatNumber(number);
    return text;
  };
  const std::vector<double> quaternion = {q.w(), q.x(), q.y(), q.z()};
  const struct {
    const char* names;
    std::vector<double> numbers;
    RotationForm form;
  } cases[] = {{"rx_rad,ry_rad,rz_rad", {vector.x(), vector.y(), vector.z()}, RotationForm::kVector},
               {"ow,ox,oy,oz", quaternion, RotationForm::kQuaternion},
               {"qw,qx,qy,qz", quaternion, RotationForm::kQuaternion},
               {"a_deg,b_deg,c_deg", {a / kDegree, b / kDegree, c / kDegree}, RotationForm::kAbc},
               {"c_mrad,b_deg,a_rad", {1e3 * c, b / kDegree, a}, RotationForm::kAbc},
               {"roll_deg,pitch_deg,yaw_deg", {c / kDegree, b / kDegree, a / kDegree}, RotationForm::kRollPitchYaw}};
  for (const auto& each : cases) {
    const Targets targets =
        Read(std::string("target,x_mm,y_mm,z_mm,") + each.names + "\nt,1,2,3" + row(each.numbers) + "\n");
    EXPECT_LT((targets.rows[0].flange_in_base->rotation - right).norm(), 1e-12) << each.names;
    EXPECT_EQ(targets.rotation_form, each.form) << each.names;
    EXPECT_TRUE(targets.shots.unread_columns.empty()) << each.names;
    EXPECT_FALSE(targets.may_be_no_vector) << each.names;
  }
}

// A, B, C under the names of a vector are read as one, which is said.
TEST(TargetFileTest, VectorsInDegreesMayBeAngles) {
  const auto may_be_none = [](const std::string& names, const std::string& numbers) {
    return Read("target,x_mm,y_mm,z_mm," + names + "\nt,1,2,3," + numbers + "\n").may_be_no_vector;
  };
  EXPECT_TRUE(may_be_none("rz_deg,ry_deg,rx_deg", "-128.11,6.65,107.6"));
  EXPECT_FALSE(may_be_none("rz_deg,ry_deg,rx_deg", "0,0,107.6"));
  EXPECT_FALSE(may_be_none("rz_mrad,ry_mrad,rx_mrad", "200,100,30"));
}

TEST(TargetFileTest, OtherColumnsAreCarriedAlongAndSaid) {
  const Targets targets = Read("target,x_mm,y_mm,z_mm,rx_mrad,ry_mrad,rz_mrad,payload,q1_cmd_deg\na,1,1,1,0,0,0,5,6\n");
  EXPECT_EQ(targets.rows.size(), 1u);
  EXPECT_EQ(targets.shots.unread_columns, (std::vector<std::string>{"payload", "q1_cmd_deg"}));
}

TEST(TargetFileTest, JointsThatOnlyFollowHaveNoValueOfTheirOwn) {
  Robot robot = Arm();
  robot.chain.joints[2].min = robot.chain.joints[2].max = 0.0;
  const auto read = [&](const std::string& third) {
    const std::string text = "target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\na,1,2," + third + ",4,5,6\n";
    return ErrorOf([&] { TargetsFromTable(ParseCsvTable(text, "targets.csv"), robot, "S1"); });
  };
  EXPECT_EQ(read("0"), "");
  EXPECT_TRUE(SaysInOrder(read("0.1"), {"targets.csv:2", "q3_deg", "does not move by itself"}));
  // A pose says nothing of it.
  robot.chain.joints[2].min = robot.chain.joints[2].max = 0.2;
  const std::string pose = "target,x_mm,y_mm,z_mm,rx_mrad,ry_mrad,rz_mrad\na,1,2,3,0,0,0\n";
  const Targets targets = TargetsFromTable(ParseCsvTable(pose, "targets.csv"), robot, "S1");
  EXPECT_EQ(targets.shots.configurations[0].q[2], 0.2);
}

struct BadTargets {
  const char* name;
  std::string text;
  std::vector<std::string> parts;  // of the error, in order
};
void PrintTo(const BadTargets& bad, std::ostream* out) { *out << bad.name; }

class BadTargetsTest : public ::testing::TestWithParam<BadTargets> {};

TEST_P(BadTargetsTest, AreRefusedWithLineAndColumn) {
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { Read(GetParam().text); }), GetParam().parts));
}

const std::string kJoints = "q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg";
const std::string kPose = "x_mm,y_mm,z_mm,rx_mrad,ry_mrad,rz_mrad";

INSTANTIATE_TEST_SUITE_P(
    Headers, BadTargetsTest,
    ::testing::Values(
        BadTargets{"NoName", kJoints + "\n0,0,0,0,0,0\n", {"t.csv:1", "target", "missing", "names each row"}},
        BadTargets{"NeitherJointsNorPose", "target,load\na,piece\n", {"t.csv:1", "neither joint values nor poses"}},
        BadTargets{"JointMissing",
                   "target,q1_deg,q2_deg,q4_deg,q5_deg,q6_deg\na,0,0,0,0,0\n",
                   {"t.csv:1", "'q3' is missing", "q3_"}},
        BadTargets{"AngleMissing",
                   "target,x_mm,y_mm,z_mm,rx_mrad,ry_mrad\na,1,1,1,0,0\n",
                   {"t.csv:1", "'rz' is missing", "rz_mrad"}},
        BadTargets{"NoRotation",
                   "target,x_mm,y_mm,z_mm\na,1,1,1\n",
                   {"t.csv:1", "rx", "no rotation", "ow, ox, oy, oz", "a_deg, b_deg, c_deg", "roll_deg"}},
        BadTargets{"NoPosition", "target,ow,ox,oy,oz\na,1,0,0,0\n", {"t.csv:1", "'x' is missing", "x_mm"}},
        BadTargets{"TwoRotations",
                   "target," + kPose + ",a_deg,b_deg,c_deg\na,1,1,1,0,0,0,1,2,3\n",
                   {"t.csv:1", "given twice", "'rx_mrad' and 'a_deg'", "keep one"}},
        BadTargets{"TwoQuaternions",
                   "target,x_mm,y_mm,z_mm,ow,ox,oy,oz,qw,qx,qy,qz\na,1,1,1,1,0,0,0,1,0,0,0\n",
                   {"t.csv:1", "given twice"}},
        BadTargets{"PartOfAQuaternion",
                   "target,x_mm,y_mm,z_mm,qw,qx,qy\na,1,1,1,1,0,0\n",
                   {"t.csv:1", "'qz' is missing", "scalar first"}},
        BadTargets{"CapitalLetters",
                   "target," + kJoints + ",A_deg,B_deg,C_deg\na,0,0,0,0,0,0,1,2,3\n",
                   {"t.csv:1", "unknown column 'A_deg'", "'a_deg'"}},
        BadTargets{"NameOfTheRowIsMisspelt",
                   "Tagret," + kJoints + "\na,0,0,0,0,0,0\n",
                   {"t.csv:1", "'target' is missing", "did you mean 'Tagret'?"}},
        BadTargets{"TwoUnits",
                   "target," + kPose + ",z_m\na,1,1,1,0,0,0,1\n",
                   {"t.csv:1", "'z' is given in two units", "keep one"}},
        BadTargets{"JointTooMany",
                   "target," + kJoints + ",q7_deg\na,0,0,0,0,0,0,0\n",
                   {"t.csv:1", "q7_deg", "it has 6 joints"}},
        BadTargets{"LoadMisspelt",
                   "target," + kJoints + ",laod\na,0,0,0,0,0,0,piece\n",
                   {"t.csv:1", "unknown column 'laod'", "load"}},
        BadTargets{"ForceInKiloponds",
                   "target," + kJoints + ",fx_kp\na,0,0,0,0,0,0,20\n",
                   {"t.csv:1", "fx_kp", "'kp' is no unit", "'fx_N'"}},
        BadTargets{"Misspelt",
                   "target," + kJoints + ",temperture_degC\na,0,0,0,0,0,0,20\n",
                   {"t.csv:1", "unknown column 'temperture_degC'", "temperature_degC"}}),
    [](const auto& bad) { return std::string(bad.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Cells, BadTargetsTest,
    ::testing::Values(
        BadTargets{"NoNumber",
                   "target," + kJoints + "\na,0,0,0,0,0,0\nb,0,0,zero,0,0,0\n",
                   {"t.csv:3", "q3_deg", "'zero' is not a finite number"}},
        BadTargets{"Beyond", "target," + kPose + ",fx_N\na,1,1,1,0,0,0,1e40\n", {"t.csv:2", "fx_N", "beyond anything"}},
        BadTargets{"HalfAPose", "target," + kPose + "\na,1,1,1,0,,0\n", {"t.csv:2", "ry_mrad", "is empty"}},
        BadTargets{"NoneInCapitals",
                   "target,load," + kJoints + "\na,none,0,0,0,0,0,0\nb,None,0,0,0,0,0,0\n",
                   {"t.csv:3", "load", "'None'", "or no load?", "written none"}},
        BadTargets{"NoUnitQuaternion",
                   "target,x_mm,y_mm,z_mm,ow,ox,oy,oz\na,1,1,1,0.9,0,0,0\n",
                   {"t.csv:2", "ow", "the length 0.9", "unit quaternion"}},
        BadTargets{
            "PositionAlone", "target,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\na,1,1,1,,,\n", {"t.csv:2", "a_deg", "is empty"}},
        BadTargets{"NoNameHere", "target," + kPose + "\n,1,1,1,0,0,0\n", {"t.csv:2", "target", "is empty"}},
        BadTargets{
            "Nothing", "target," + kPose + "\na,,,,,,\n", {"t.csv:2", "'a' has neither joint values nor a pose"}},
        BadTargets{
            "Direction", "target," + kPose + ",approach3\na,1,1,1,0,0,0,2\n", {"t.csv:2", "approach3", "-1, 0 or 1"}}),
    [](const auto& bad) { return std::string(bad.param.name); });

// What a spreadsheet or a controller writes is what target files say: cells and names both.
class ForeignTargetsTest : public FileTest {
 protected:
  Targets ReadList(const std::string& text) {
    Write("list.csv", text);
    return ReadTargets(Path("list.csv"), Arm(), "S1");
  }
};

TEST_F(ForeignTargetsTest, SemicolonsDecimalCommasAndOtherNames) {
  const Targets targets = ReadList(
      "Name;A1 [deg];A2 [deg];A3 [deg];A4 [deg];A5 [deg];A6 [deg];Station;Remark\n"
      "001;10,5;-86;80;0;15;0;S2;1,5 turns\n");
  ASSERT_EQ(targets.rows.size(), 1u);
  EXPECT_EQ(targets.rows[0].name, "001");
  EXPECT_NEAR((*targets.rows[0].q)[0], 10.5 * kDegree, 1e-15);
  EXPECT_NEAR((*targets.rows[0].q)[4], 15 * kDegree, 1e-15);
  EXPECT_EQ(targets.shots.stations, std::vector<std::string>{"S2"});
  EXPECT_EQ(targets.shots.unread_columns, std::vector<std::string>{"Remark"});
  EXPECT_EQ(targets.shots.files[0].rows[0].line, 2);
  ASSERT_EQ(targets.notes.size(), 2u);
  EXPECT_TRUE(SaysInOrder(targets.notes[0], {"list.csv", "semicolon", "decimal comma"}));
  EXPECT_TRUE(SaysInOrder(targets.notes[1], {"'Name' as target", "'A1 [deg]' as q1_deg", "'Station' as station"}));
}

// Numbers of orders and batches are whoever wrote them's own: they come back as they stood there.
TEST_F(ForeignTargetsTest, ColumnsThatAreNotReadKeepTheirCells) {
  const Targets targets = ReadList(
      "Name;A1 [deg];A2 [deg];A3 [deg];A4 [deg];A5 [deg];A6 [deg];Auftrag;Charge\n"
      "P1;1.010,5;-86;80;0;15;0;0012,50;1.234,50\n");
  EXPECT_NEAR((*targets.rows[0].q)[0], 1010.5 * kDegree, 1e-12);
  EXPECT_EQ(targets.shots.unread_columns, (std::vector<std::string>{"Auftrag", "Charge"}));
  const auto cells = targets.shots.files[0].rows[0].cells;
  EXPECT_EQ(cells[1], "1010.5");
  EXPECT_EQ(cells[7], "0012,50");
  EXPECT_EQ(cells[8], "1.234,50");
}

// A rail that is called X: a column X is its value where no pose stands in the list.
TEST_F(ForeignTargetsTest, JointsMayBeCalledAsAxesAre) {
  Robot rail = Arm();
  rail.chain.joints[0].name = "X";
  rail.chain.joints[0].type = JointType::kPrismatic;
  const auto read = [&](const std::string& text) {
    Write("list.csv", text);
    return ReadTargets(Path("list.csv"), rail, "S1");
  };
  const std::string others = "A2 [deg];A3 [deg];A4 [deg];A5 [deg];A6 [deg]";
  const Targets targets = read("Name;X [mm];" + others + "\nP1;1000,5;-60;30;0;20;5\n");
  EXPECT_NEAR((*targets.rows[0].q)[0], 1.0005, 1e-12);
  EXPECT_FALSE(targets.rows[0].flange_in_base);
  const std::string open = "Name;X [mm];Y [mm];Z [mm];" + others + "\nP1;1000;7;8;-60;30;0;20;5\n";
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { read(open); }), {"list.csv:1", "q1", "missing"}));
  for (const int j : {1, 2}) {
    rail.chain.joints[j].name = j == 1 ? "Y" : "Z";
    rail.chain.joints[j].type = JointType::kPrismatic;
  }
  const Targets gantry = read("Name;X [mm];Y [mm];Z [mm];A4 [deg];A5 [deg];A6 [deg]\nP1;1000;7;8;0;20;5\n");
  EXPECT_NEAR((*gantry.rows[0].q)[2], 0.008, 1e-12);
  const Targets poses = read("Name;X [mm];Y [mm];Z [mm];A [deg];B [deg];C [deg]\nP1;1000;2;3;10;20;30\n");
  EXPECT_FALSE(poses.rows[0].q);
  EXPECT_EQ(poses.rows[0].flange_in_base->translation.x(), 1.0);
}

// KUKA: Rz(A) Ry(B) Rx(C). FANUC: W, P and R turn about fixed x, y and z.
TEST_F(ForeignTargetsTest, AnglesOfControllers) {
  const auto rotation = [this](const std::string& names, const std::string& numbers) {
    return ReadList("target,X [mm],Y [mm],Z [mm]," + names + "\nt,1,2,3," + numbers + "\n")
        .rows[0]
        .flange_in_base->rotation;
  };
  const Matrix3<double> right =
      Read("target,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\nt,1,2,3,10,20,30\n").rows[0].flange_in_base->rotation;
  EXPECT_EQ(rotation("A [deg],B [deg],C [deg]", "10,20,30"), right);
  EXPECT_EQ(rotation("W (deg),P (deg),R (deg)", "30,20,10"), right);
}

// A name without its unit, a column that is there already, commanded values.
TEST_F(ForeignTargetsTest, WhatDoesNotSayEnoughKeepsItsName) {
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadList("Name;A1;A2;A3;A4;A5;A6\na;0;0;0;0;0;0\n"); }),
                          {"list.csv:1", "neither joint values nor poses", "q1_deg (A1)"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadList("target," + kPose + ",X [mm]\na,1,2,3,0,0,0,9\n"); }),
                          {"list.csv:1", "X [mm]", "'x_mm'"}));
  const Targets targets = ReadList("target," + kPose + ",payload\na,1,2,3,0,0,0,5\n");
  EXPECT_EQ(targets.rows[0].flange_in_base->translation.x(), 1e-3);
  EXPECT_EQ(targets.shots.unread_columns, std::vector<std::string>{"payload"});
  EXPECT_TRUE(targets.notes.empty());
}

}  // namespace
}  // namespace sagitta::target_file_test
