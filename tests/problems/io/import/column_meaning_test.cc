// What the names of columns say, one by one and together.
#include "problems/io/import/column_meaning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "problems/io/import/time_column.h"

namespace sagitta::column_meaning_test {
namespace {

std::vector<Joint> OnRail(const std::string& rail, const std::string& word) {
  std::vector<Joint> joints(7);
  joints[0].name = rail;
  joints[0].type = JointType::kPrismatic;
  for (int j = 1; j < 7; ++j) joints[static_cast<size_t>(j)].name = word + std::to_string(j);
  return joints;
}

std::vector<int> JointsOf(const std::vector<std::string>& headers, const std::vector<Joint>& joints) {
  std::vector<int> indices;
  for (const ColumnMeaning& meaning : MeaningsOf(headers, joints)) {
    indices.push_back(meaning.role == Role::kJoint ? meaning.index : -9);
  }
  return indices;
}

TEST(ColumnMeanings, UnitsPartARailFromTheArm) {
  const std::vector<std::string> arm = {"A1 [deg]", "A2 [deg]", "A3 [deg]", "A4 [deg]", "A5 [deg]", "A6 [deg]"};
  for (const char* rail : {"E1 [mm]", "Rail [mm]"}) {
    std::vector<std::string> headers = {rail};
    headers.insert(headers.end(), arm.begin(), arm.end());
    EXPECT_THAT(JointsOf(headers, OnRail("E1", "j")), ::testing::ElementsAre(0, 1, 2, 3, 4, 5, 6)) << rail;
    for (const char* joint : {"T", "R1", "rail", "L"}) {
      for (const char* word : {"J", "A", "joint_"})
        EXPECT_THAT(JointsOf(headers, OnRail(joint, word)), ::testing::ElementsAre(0, 1, 2, 3, 4, 5, 6))
            << rail << " " << joint << " " << word;
    }
  }
  // An angle is no place on a rail.
  EXPECT_THAT(JointsOf({"E1 [deg]"}, OnRail("T", "J")), ::testing::ElementsAre(-9));
  // Counted through the arm, as our own columns are.
  EXPECT_THAT(JointsOf({"q1_mm", "q2_deg", "q3_deg", "q4_deg", "q5_deg", "q6_deg", "q7_deg"}, OnRail("E1", "j")),
              ::testing::ElementsAre(0, 1, 2, 3, 4, 5, 6));
  // Joints that are not named by numbers are counted through, too.
  std::vector<Joint> named = OnRail("rail", "j");
  named[3].name = "elbow";
  EXPECT_THAT(JointsOf({"A1 [deg]", "A2 [deg]"}, named), ::testing::ElementsAre(0, 1));
}

TEST(ColumnMeanings, PendantNamesAreJointsTogether) {
  const std::vector<Joint> none;
  EXPECT_THAT(JointsOf({"Base", "shoulder", "Elbow", "wrist1", "Wrist 2", "wrist_3 [deg]"}, none),
              ::testing::ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(JointsOf({"Base", "J1 [deg]"}, none), ::testing::ElementsAre(-9, 0));
}

TEST(ColumnMeanings, ExpandedUncertaintiesAreNoStandardDeviations) {
  for (const char* header : {"U95 X [mm]", "Uncertainty X (k=2) [mm]", "Expanded uncertainty x", "U95_x_mm"}) {
    const ColumnMeaning meaning = MeaningOf(header, {});
    EXPECT_EQ(meaning.role, Role::kOther) << header;
    EXPECT_THAT(meaning.why, ::testing::HasSubstr("2 sigma")) << header;
  }
  EXPECT_THAT(MeaningOf("Ux", {}).why, ::testing::HasSubstr("uncertainty"));
  EXPECT_EQ(MeaningOf("Uncertainty X [mm]", {}).role, Role::kSigma);
}

TEST(TimeStamps, AreReadAsPeopleWriteThem) {
  const double nine = 1710234011.0;  // date -u -d '2024-03-12 09:00:11' +%s
  for (const char* stamp : {"20240312090011", "2024-03-12 09:00:11", "2024-03-12T09:00:11Z", "2024/03/12 09:00:11",
                            "12.03.2024 09:00:11", "12.3.2024 9:00:11"}) {
    EXPECT_EQ(SecondsOfStamp(stamp), nine) << stamp;
  }
  EXPECT_EQ(SecondsOfStamp("2024-03-12 09:00:11.25"), nine + 0.25);
  for (const char* none : {"", "09:00:11", "2024-13-12 09:00:11", "1710234011", "03/12/2024 09:00:11"}) {
    EXPECT_FALSE(SecondsOfStamp(none)) << none;
  }
}

// A number in a unit that is not read is no number in ours.
TEST(ColumnMeanings, UnitsThatAreNotReadLeaveAColumnOut) {
  for (const char* header : {"Temp [K]", "Temp (°F)", "temperature_degF", "temperature_K", "Torque A1 [%]", "std_x [%]",
                             "x [ft]", "Temperature [°R]"}) {
    const ColumnMeaning meaning = MeaningOf(header, {"A1"});
    EXPECT_EQ(meaning.role, Role::kOther) << header;
    EXPECT_THAT(meaning.why, ::testing::HasSubstr("is no unit")) << header;
  }
  for (const char* header : {"Temp [°C]", "temperature_degC", "Temp", "Temperature (ambient)"})
    EXPECT_EQ(MeaningOf(header, {}).role, Role::kTemperature) << header;
  EXPECT_EQ(MeaningOf("X (measured)", {}).role, Role::kPoint);
  EXPECT_EQ(MeaningOf("Torque A1 [Nm]", {"A1"}).role, Role::kTorque);
}

TEST(ColumnMeanings, ADurationIsNoTimeAndAMotorIsNotTheAir) {
  EXPECT_EQ(MeaningOf("Exposure time [s]", {}).role, Role::kOther);
  EXPECT_EQ(MeaningOf("Temp motor A1 [°C]", {}).role, Role::kOther);
  EXPECT_EQ(MeaningOf("Measured time [s]", {}).role, Role::kTime);
}

// Universal Robots' names stand within names of much else.
TEST(ColumnMeanings, WhatElseIsSaidOfAJointIsNotItsValue) {
  for (const char* header : {"Elbow temperature [degC]", "elbow_temp", "velocity.shoulder_pan_joint", "wrist_1 speed",
                             "wrist_2 current", "J3 temperature [degC]", "Wrist temperature [degC]", "A1 Temp [°C]"}) {
    EXPECT_EQ(MeaningOf(header, {}).role, Role::kOther) << header;
  }
  for (const char* header : {"position.elbow_joint", "actual elbow", "ur5/elbow_joint", "robax.rax_3", "rax_3"}) {
    EXPECT_EQ(MeaningOf(header, {}).role, Role::kJoint) << header;
    EXPECT_EQ(MeaningOf(header, {}).index, 2) << header;
  }
  EXPECT_EQ(MeaningOf("speed_joint", {"speed_joint"}).role, Role::kJoint);  // the robot's own name
  EXPECT_EQ(MeaningOf("effort.elbow_joint", {}).role, Role::kTorque);
  EXPECT_EQ(MeaningOf("Base temperature [degC]", {}).role, Role::kTemperature);
}

// Of Motoman's arms the ends of the names look like units, and "t" like a target.
TEST(ColumnMeanings, OwnNamesOfJointsMeanNothingElse) {
  const std::vector<std::string> names = {"joint_1_s", "joint_2_l", "joint_6_t", "T"};
  for (const char* header : {"joint_1_s", " Joint_1_S ", "position.joint_1_s", "joint_1_s [deg]"}) {
    const ColumnMeaning meaning = MeaningOf(header, names);
    EXPECT_EQ(meaning.role, Role::kJoint) << header;
    EXPECT_EQ(meaning.index, 0) << header;
    EXPECT_FALSE(meaning.is_numbered) << header;
    EXPECT_EQ(meaning.unit, std::string(header).find('[') == std::string::npos ? "" : "deg") << header;
  }
  for (const char* header : {"joint_6_t [deg]", "joint_6_t", "T [mm]", "T_mm", "T"}) {
    EXPECT_EQ(MeaningOf(header, names).role, Role::kJoint) << header;
    EXPECT_FALSE(MeaningOf(header, names).is_commanded) << header;
  }
  EXPECT_TRUE(MeaningOf("t_q1", names).is_commanded);
}

TextTable Times(const std::string& header, const std::vector<std::string>& cells) {
  TextTable table;
  table.header = {header};
  table.header_line = 1;
  for (const std::string& cell : cells) table.rows.push_back({2, {cell}});
  return table;
}

// The first column, of so many shots.
TimeColumn Look(const TextTable& table, size_t shots) {
  PlannedColumn column;
  column.source = 0;
  std::vector<size_t> rows;
  for (size_t shot = 0; shot < shots; ++shot) rows.push_back(shot * table.rows.size() / shots);
  return LookAtTime(table, column, rows);
}

TEST(TimeColumns, NumbersAreInTheUnitOfTheHeader) {
  const std::vector<std::string> numbers = {"0", "1.5", "3"};
  const std::pair<const char*, double> units[] = {{"Time [s]", 1.0},      {"time_s", 1.0},      {"time_ms", 1e-3},
                                                  {"t (ns)", 1e-9},       {"Time [min]", 60.0}, {"time_h", 3600.0},
                                                  {"Time days", 86400.0}, {"elapsed_us", 1e-6}};
  for (const auto& [header, seconds] : units) {
    const TimeColumn time = Look(Times(header, numbers), 3);
    EXPECT_EQ(time.why_not, "") << header;
    EXPECT_EQ(time.seconds_per_unit, seconds) << header;
  }
  EXPECT_FALSE(Look(Times("Time", numbers), 3).seconds_per_unit);
  for (const char* header : {"Time [mm]", "Time [m]", "Time (UTC)"})
    EXPECT_THAT(Look(Times(header, numbers), 3).why_not, ::testing::HasSubstr("is no unit")) << header;
  EXPECT_EQ(Look(Times("Time (UTC)", {"2024-03-12 09:00:11", "2024-03-12 09:01:11"}), 2).why_not, "");
}

// 2023-11-14 22:13:20 and later, as computers count it; in s the unit is a guess as of any number.
TEST(TimeColumns, NumbersSince1970StateTheirUnitByTheirSize) {
  const std::pair<const char*, double> clocks[] = {{"000", 1e-3}, {"000000", 1e-6}, {"000000000", 1e-9}};
  for (const auto& [zeros, seconds] : clocks) {
    std::vector<std::string> stamps;
    for (const char* time : {"1700000000", "1700000060", "1700000120"}) stamps.push_back(std::string(time) + zeros);
    const TimeColumn time = Look(Times("timestamp", stamps), 3);
    EXPECT_TRUE(time.since_1970);
    EXPECT_EQ(time.seconds_per_unit, seconds);
  }
  EXPECT_FALSE(Look(Times("timestamp", {"1700000000", "1700000060"}), 2).since_1970);
}

// tx, ty, tz are a point where no other column is one.
TEST(ColumnMeanings, TranslationsArePointsWhereNothingElseIs) {
  const std::vector<std::string> names = {"pose", "tx", "ty [mm]", "tz", "qx", "qy", "qz", "qw"};
  const auto point = [](std::vector<std::string> headers) {
    std::vector<int> axes;
    for (const ColumnMeaning& meaning : MeaningsOf(headers, {})) {
      if (meaning.role == Role::kPoint) axes.push_back(meaning.index);
    }
    return axes;
  };
  EXPECT_EQ(point(names), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(point({"x", "y", "z", "tx", "ty", "tz"}), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(point({"tx", "ty"}), std::vector<int>());
  EXPECT_EQ(point({"tx [Nm]", "ty [Nm]", "tz [Nm]"}), std::vector<int>());
}

// Motion capture writes what is turned and moved a line above X, Y, Z.
TEST(TextTables, NamesThatStandTwiceHaveTheLineAbove) {
  const TextTable table = ParseTextTable(
      "Format,1.23,Units,Millimeters\n,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Error\n"
      "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,\n0,0.0,0.1,0.2,0.3,0.9,1,2,3,0.2\n1,1.0,0.1,0.2,0.3,0.9,1,2,4,0.2\n",
      "m.csv");
  EXPECT_EQ(table.header,
            (std::vector<std::string>{"Frame", "Time (Seconds)", "Rotation X", "Rotation Y", "Rotation Z", "Rotation W",
                                      "Position X", "Position Y", "Position Z", "Mean Error"}));
  EXPECT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(ParseTextTable("a,b,c\nX,Y,Z\n1,2,3\n", "m.csv").header, (std::vector<std::string>{"X", "Y", "Z"}));
}

TEST(TextTables, CommentsOfThreeKinds) {
  for (const char* sign : {"#", "%", "//", "  // "}) {
    const TextTable table =
        ParseTextTable(std::string(sign) + " points of job A, mm\nP1 1.5 2.5 3.5\nP2 1.5 2.5 4.5\n", "m.txt");
    EXPECT_EQ(table.rows.size(), 2U) << sign;
    EXPECT_EQ(table.preamble,
              (std::vector<std::string>{(sign[0] == ' ' ? "  " : " ") + std::string("points of job A, mm")}))
        << sign;
  }
}

// What is one shot is known when all columns are: a visit to the right of the time is one.
TEST(TimeColumns, AreDecidedAfterAllOthers) {
  TextTable table;
  table.header = {"time_s", "visit"};
  table.header_line = 1;
  for (int r = 0; r < 8; ++r) table.rows.push_back({r + 2, {std::to_string(r / 4), "v" + std::to_string(r % 4)}});
  ImportPlan plan;
  for (const char* stem : {"time", "visit"}) {
    PlannedColumn column;
    column.stem = stem;
    column.header = table.header[plan.columns.size()];
    column.source = static_cast<int>(plan.columns.size());
    plan.columns.push_back(column);
  }
  std::vector<ImportPlan> plans = {plan};
  DecideTimes(table, &plans);
  EXPECT_EQ(plans[0].Find("time"), nullptr);
  ASSERT_EQ(plans[0].unused.size(), 1U);
  EXPECT_EQ(plans[0].unused[0].first, "time_s");
  EXPECT_THAT(plans[0].unused[0].second, ::testing::HasSubstr("rounded"));
  plan.columns.pop_back();
  plans = {plan};
  DecideTimes(table, &plans);
  EXPECT_NE(plans[0].Find("time"), nullptr);
}

TEST(PartsOfNames, AreCountedWithoutEmptyOnes) {
  const std::string name = "A::SMR1::P001";
  EXPECT_EQ(PartOfName(name, NamePart::kFirst), "A");
  EXPECT_EQ(PartOfName(name, NamePart::kSecond), "SMR1");
  EXPECT_EQ(PartOfName(name, NamePart::kThird), "P001");
  EXPECT_EQ(PartOfName(name, NamePart::kFourth), "");
  EXPECT_EQ(PartOfName(name, NamePart::kLast), "P001");
}

// Three markers of a shot share its time.
TEST(TimeColumns, TimesOfShotsAreNotRounded) {
  const TextTable table = Times("time_s", {"0", "0", "0", "9", "9", "9"});
  EXPECT_EQ(Look(table, 2).why_not, "");
  EXPECT_THAT(Look(table, 6).why_not, ::testing::HasSubstr("rounded"));
}

}  // namespace
}  // namespace sagitta::column_meaning_test
