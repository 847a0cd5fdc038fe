// Readings in one file, the joint values of their poses in another.
#include "tests/tools/import_tables.h"

#ifdef SAGITTA_HAVE_KDL

#include <numeric>
#include <random>

namespace sagitta::import_joined_test {
namespace {

using test::Readings;
using test::Table;

std::string PoseName(size_t row) { return "plan" + std::to_string(row + 1); }

// What an instrument writes: of every pose a name and the point.
Table Points() {
  Table table = Table(Readings()).Reordered({6, 7, 8});
  table.header = {"X", "Y", "Z"};
  return table.Insert(0, "Point Name", PoseName);
}

// What a plan has: names and joint values, in another order.
std::string Poses(const std::string& separator = ",") {
  Table table = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5}).With(separator);
  table.Insert(0, "config", PoseName).Insert(1, "marker", [](size_t) { return std::string("M1"); });
  std::reverse(table.rows.begin(), table.rows.end());
  return table.ToText();
}

class ImportJoined : public test::Import {
 protected:
  std::vector<std::string> Column(const std::string& name) const {
    const auto cells = test::Cells(Read("job/measurements.csv"));
    std::vector<std::string> column;
    for (size_t r = 1; r < cells.size(); ++r) column.push_back(cells[r][test::Column(cells, name)]);
    return column;
  }
  // ExpectRight imports export.txt and what else is named.
  std::vector<std::string> With(const std::string& poses, std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), Write("poses.csv", poses));
    return flags;
  }
};

TEST_F(ImportJoined, NamesOfPosesJoinReadingsWithJointValues) {
  ExpectRight(Points().ToText(), Readings(), With(Poses()));
  EXPECT_EQ(Column("config")[4], "plan5");
  EXPECT_EQ(Column("source")[4], "export.txt:6");
  const test::Outcome outcome = ImportText(Points().ToText(), With(Poses()));
  EXPECT_NE(outcome.out.find("'Point Name' names the poses of"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("left out"), std::string::npos) << outcome.out;
}

TEST_F(ImportJoined, EachFileHasItsOwnSeparatorAndDecimalSign) {
  ExpectRight(Points().DecimalComma().With(";").ToText(), Readings(), With(Poses("\t")));
}

TEST_F(ImportJoined, ANameAndThreeNumbersNeedNoHeader) {
  Table points = Points().With(" ");
  points.header.clear();
  ExpectRight(points.ToText(), Readings(), With(Poses()));
}

// In one file with the joint values a name is the pose's, whatever its header, where each has its own joint values.
TEST_F(ImportJoined, NamesNextToJointValuesAreKept) {
  for (const char* header : {"Punkt", "Bezeichnung"}) {
    Table table{Readings()};
    ExpectRight(table.Insert(0, header, PoseName).ToText(), Readings(), {"--strict"});
    EXPECT_EQ(Column("config")[4], "plan5") << header;
  }
  Table shared{Readings()};
  shared.Insert(0, "Punkt", [](size_t row) { return "P" + std::to_string(row / 2); });
  ExpectRight(shared.ToText(), Readings());
  EXPECT_EQ(Column("config")[4], "c00005");
}

TEST_F(ImportJoined, AMarkersNameBehindThePoses) {
  Table points = Points();
  for (auto& row : points.rows) row[0] = "PLAN-" + row[0].substr(4) + "_SMR1";
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "pose", [](size_t row) { return "plan-" + std::to_string(row + 1); });
  ExpectRight(points.ToText(), Readings(), With(poses.ToText()));
}

// As SpatialAnalyzer exports them: comments with two strokes, three parts of a name.
TEST_F(ImportJoined, PointsOfSpatialAnalyzer) {
  Table points = Points().With(" ");
  points.header.clear();
  points.preamble = "// SpatialAnalyzer export, points of job A\n// Units: mm, Deg\n";
  for (auto& row : points.rows) row[0] = "A::SMR1::" + row[0];
  ExpectRight(points.ToText(), Readings(), With(Poses()));
}

// Points that are measured next to the poses (of a reference frame) have no joint values.
TEST_F(ImportJoined, ReadingsOfNoPoseAreLeftOutAndSaid) {
  Table points = Points();
  points.rows.push_back({"REF1", "10.5", "20.5", "30.5"});
  ExpectRight(points.ToText(), Readings(), With(Poses()));
  const test::Outcome outcome = ImportText(points.ToText(), With(Poses()));
  EXPECT_NE(outcome.out.find("1 readings, which are left out: 'REF1'"), std::string::npos) << outcome.out;
  ExpectRefused(points.ToText(), {"--strict", "'REF1'"}, With(Poses(), {"--strict"}));
}

TEST_F(ImportJoined, WithoutNamesAsManyRowsAreInOrderWhichIsAGuess) {
  Table points = Table(Readings()).Reordered({6, 7, 8});
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  ExpectRight(points.ToText(), Readings(), With(poses.ToText()));
  ExpectRefused(points.ToText(), {"--strict", "same order"}, With(poses.ToText(), {"--strict"}));
  // In another order the robot cannot have made them.
  std::reverse(poses.rows.begin(), poses.rows.end());
  EXPECT_EQ(ImportText(points.ToText(), With(poses.ToText())).status, 2);
}

// Two rounds, or all poses for one marker or station and then for the next: half the file away are the same joint
// values.
TEST_F(ImportJoined, AnOrderThatRepeatsItselfIsConfirmed) {
  const std::vector<test::Reading> other = test::MakeReadings(false, KDL::Vector(-0.04, 0.02, 0.08));
  std::vector<test::Reading> rounds = Readings(), markers = Readings();
  for (test::Reading again : Readings()) {
    again.xyz_mm[1] += 0.002;
    rounds.push_back(again);
  }
  markers.insert(markers.end(), other.begin(), other.end());
  const auto of = [](size_t row) { return std::string(row < 30 ? "M1" : "M2"); };
  for (const bool are_markers : {false, true}) {
    const std::vector<test::Reading>& readings = are_markers ? markers : rounds;
    Table points = Table(readings).Reordered({6, 7, 8});
    if (are_markers) points.Insert(3, "marker", of);
    Table poses = Table(readings).Reordered({0, 1, 2, 3, 4, 5});
    ExpectRight(points.ToText(), readings, With(poses.ToText()));
    // The same rows one on.
    Table shifted = points;
    std::rotate(shifted.rows.begin(), shifted.rows.begin() + 1, shifted.rows.end());
    EXPECT_EQ(ImportText(shifted.ToText(), With(poses.ToText())).status, 2) << are_markers;
  }
}

// A plan states the times and temperatures that it was made for. Those of the readings are others.
TEST_F(ImportJoined, TimesAndTemperaturesOfAListAreNotMeasured) {
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "config", PoseName);
  poses.Insert(7, "time_s", [](size_t row) { return std::to_string(60 * row); });
  poses.Insert(8, "temperature_degC", [](size_t row) { return test::Text(20.0 + 0.2 * static_cast<double>(row)); });
  Table in_order = Table(Readings()).Reordered({6, 7, 8});
  for (const std::string& points : {Points().ToText(), in_order.ToText()}) {
    ExpectRight(points, Readings(), With(poses.ToText()));
    const std::string written = Read("job/measurements.csv");
    EXPECT_EQ(written.find("temperature_degC"), std::string::npos);
    EXPECT_EQ(written.find("time_s"), std::string::npos);
    const test::Outcome outcome = ImportText(points, With(poses.ToText()));
    EXPECT_NE(outcome.out.find("--map=temperature_degC=temperature_degC uses it"), std::string::npos) << outcome.out;
  }
  // Who says that they are those of the readings is believed, and a time of their own is used.
  Table own = Points();
  own.Insert(4, "Time [s]", [](size_t row) { return std::to_string(500 + 45 * row); });
  ExpectRight(own.ToText(), Readings(), With(poses.ToText(), {"--map=temperature_degC=temperature_degC"}));
  EXPECT_EQ(Column("temperature_degC")[5], "21");
  EXPECT_EQ(Column("time_s")[1], "545");
}

// Numbers of poses next to numbers of markers: each of these is a pose's, too, but they say less.
TEST_F(ImportJoined, NumbersOfMarkersAreNoPoses) {
  Table points = Table(Readings()).Reordered({6, 7, 8});
  points.header = {"X", "Y", "Z"};
  points.Insert(0, "Nr", [](size_t row) { return std::to_string(row + 1); });
  points.Insert(0, "Reflector", [](size_t) { return std::string("1"); });
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "Nr", [](size_t row) { return std::to_string(row + 1); });
  ExpectRight(points.ToText(), Readings(), With(poses.ToText()));
  EXPECT_EQ(Column("config")[6], "7");
  EXPECT_EQ(Column("marker")[6], "1");
}

TEST_F(ImportJoined, NamesOfOtherPosesAreRefused) {
  Table points = Points();
  for (auto& row : points.rows) row[0] = "x" + row[0];
  points.rows.pop_back();
  ExpectRefused(points.ToText(), {"export.txt", "no column names the poses of", "'plan30'"}, With(Poses()));
}

// One pose without and with a load: the reading's name has to say which.
TEST_F(ImportJoined, APoseWithTwoLoadsNeedsToBeSaid) {
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "config", PoseName);
  const std::vector<std::vector<std::string>> once = poses.rows;
  poses.rows.insert(poses.rows.end(), once.begin(), once.end());
  poses.Insert(1, "load", [&](size_t row) { return std::string(row < once.size() ? "none" : "W80"); });
  ExpectRefused(Points().ToText(), {"export.txt:2", "'none'", "'W80'", "column 'load'"}, With(poses.ToText()));
  Table named = Points();
  for (size_t r = 0; r < named.rows.size(); ++r) named.rows[r][0] += r % 2 == 0 ? "_W80" : "_none";
  ASSERT_EQ(ImportText(named.ToText(), With(poses.ToText())).status, 0);
  EXPECT_EQ(Column("load")[0], "W80");
  EXPECT_EQ(Column("load")[1], "none");
}

// Names of which some hold more than the pose's: repeats. Numbers with zeros in front are the same numbers.
TEST_F(ImportJoined, RepeatsAndLeadingZeros) {
  Table points = Points();
  const size_t count = points.rows.size();
  for (size_t r = 0; r < count; ++r) {
    points.rows.push_back(points.rows[r]);
    points.rows.back()[0] += r % 2 == 0 ? "_rep2" : " (2)";
    points.rows.back()[1] = test::Text(Readings()[r].xyz_mm[0] + 0.001, 17);
    points.rows[r][0] = "Plan" + std::string(r < 9 ? "00" : "0") + std::to_string(r + 1);
  }
  std::vector<test::Reading> twice = Readings();
  for (test::Reading again : Readings()) {
    again.xyz_mm[0] += 0.001;
    twice.push_back(again);
  }
  ExpectRight(points.ToText(), twice, With(Poses()));
  EXPECT_EQ(Column("config")[3], "plan4");
  EXPECT_EQ(Column("config")[33], "plan4");
}

TEST_F(ImportJoined, ACountOfRowsIsNoName) {
  Table points = Points();
  points.Insert(0, "No", [](size_t row) { return std::to_string(row + 1); });
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "Pose", PoseName);
  std::reverse(poses.rows.begin(), poses.rows.end());
  poses.Insert(0, "No", [](size_t row) { return std::to_string(row + 1); });
  ExpectRight(points.ToText(), Readings(), With(poses.ToText()));
}

// Each file has the readings of one marker, and the list one row for each.
TEST_F(ImportJoined, MarkersInFilesOfTheirOwn) {
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "config", PoseName).Insert(1, "marker", [](size_t) { return std::string("SMR1"); });
  const size_t count = poses.rows.size();
  for (size_t r = 0; r < count; ++r) {
    poses.rows.push_back(poses.rows[r]);
    poses.rows.back()[1] = "SMR2";
  }
  Table other{test::MakeReadings(false, KDL::Vector(-0.04, 0.02, 0.08))};
  other = other.Reordered({6, 7, 8});
  other.header = {"X", "Y", "Z"};
  other.Insert(0, "Point Name", PoseName);
  const test::Outcome outcome =
      ImportText(Points().ToText(), With(poses.ToText(), {Write("second.txt", other.ToText())}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::vector<std::string> markers = Column("marker");
  ASSERT_EQ(markers.size(), 60u);
  EXPECT_EQ(markers[0], "M1");
  EXPECT_EQ(markers[59], "M2");
  EXPECT_EQ(Column("config")[59], "plan30");
}

TEST_F(ImportJoined, TwoListsAreOneUnlessTheyContradictEachOther) {
  Table first = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  first.Insert(0, "config", PoseName);
  Table second = first;
  first.rows.resize(15);
  second.rows.erase(second.rows.begin(), second.rows.begin() + 15);
  ExpectRight(Points().ToText(), Readings(), With(first.ToText(), {Write("second.csv", second.ToText())}));
  Table actual = first;
  for (auto& row : actual.rows) row[2] = test::Text(std::stod(row[2]) + 0.2);
  ExpectRefused(Points().ToText(), {"second.csv", "other joint values here than in", "not both"},
                With(first.ToText(), {Write("second.csv", actual.ToText())}));
  second.header[6] = "q6_rad";
  ExpectRefused(Points().ToText(), {"second.csv", "a second list of poses"},
                With(first.ToText(), {Write("second.csv", second.ToText())}));
}

// A controller's list has the nominal points, too.
TEST_F(ImportJoined, PointsOfAListArePlanned) {
  Table poses{test::MakeReadings(true)};
  poses.header[6] = "X", poses.header[7] = "Y", poses.header[8] = "Z";
  poses.Insert(0, "config", PoseName);
  ExpectRight(Points().ToText(), Readings(), With(poses.ToText()));
  const test::Outcome outcome = ImportText(Points().ToText(), With(poses.ToText()));
  EXPECT_NE(outcome.out.find("poses.csv are not measured: the points are in"), std::string::npos) << outcome.out;
}

// Collection, group and name in front of a point, a time behind it; the first readings were lost.
TEST_F(ImportJoined, WhatInstrumentsWriteAroundAPoint) {
  Table points = Points();
  points.Insert(0, "Collection", [](size_t) { return std::string("A"); });
  points.Insert(1, "Group", [](size_t) { return std::string("Main"); });
  points.Insert(6, "Stamp", [](size_t) { return std::string("11/27/2026 10:15:00 AM"); });
  for (const size_t lost : {0u, 1u}) {
    for (size_t c = 3; c < 6; ++c) points.rows[lost][c] = lost == 0 ? "" : "NaN";
  }
  ExpectRight(points.ToText(), Readings(), With(Poses()), {0, 1});
}

TEST_F(ImportJoined, AFileWithoutPointsIsTheOneThatIsRefused) {
  Table points = Points();
  points.header.clear();
  points.Insert(1, "", [](size_t) { return std::string("ok"); });
  ExpectRefused(points.ToText(), {"export.txt", "no column says that it holds measured points", "poses.csv"},
                With(Poses()));
}

// Marker and load behind the pose's name, in any order; and where the list has no such row.
TEST_F(ImportJoined, NamesHoldMarkerAndLoad) {
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "config", [](size_t row) { return "P" + std::to_string(row + 1); });
  const std::vector<std::vector<std::string>> once = poses.rows;
  for (int more = 0; more < 3; ++more) poses.rows.insert(poses.rows.end(), once.begin(), once.end());
  poses.Insert(1, "marker", [&](size_t row) { return "M" + std::to_string(1 + row / once.size() % 2); });
  poses.Insert(2, "load", [&](size_t row) { return std::string(row / once.size() < 2 ? "none" : "L50"); });
  Table points = Points();
  for (size_t r = 0; r < points.rows.size(); ++r) {
    points.rows[r][0] = r % 2 == 0 ? "l50-p" + std::to_string(r + 1) + "-m2" : "P" + std::to_string(r + 1) + "_none_M2";
  }
  ASSERT_EQ(ImportText(points.ToText(), With(poses.ToText())).status, 0);
  const std::vector<std::string> markers = Column("marker"), loads = Column("load"), configs = Column("config");
  for (size_t r = 0; r < markers.size(); ++r) {
    EXPECT_EQ(markers[r], "M2");
    EXPECT_EQ(loads[r], r % 2 == 0 ? "L50" : "none");
    EXPECT_EQ(configs[r], "P" + std::to_string(r + 1));
  }
  // Pose 1 was planned without a load alone.
  poses.rows.erase(std::remove_if(poses.rows.begin(), poses.rows.end(),
                                  [](const auto& row) { return row[0] == "P1" && row[2] == "L50"; }),
                   poses.rows.end());
  ExpectRefused(points.ToText(), {"export.txt:2", "says 'L50', with which its pose does not stand"},
                With(poses.ToText()));
}

TEST_F(ImportJoined, NamesThatDifferInLetterCaseAreTwo) {
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5}), points = Points();
  const auto name = [](size_t row) { return std::string(row % 2 == 0 ? "a" : "A") + std::to_string(row / 2 + 1); };
  poses.Insert(0, "config", name);
  for (size_t r = 0; r < points.rows.size(); ++r) points.rows[r][0] = name(r);
  ExpectRight(points.ToText(), Readings(), With(poses.ToText()));
  EXPECT_EQ(Column("config")[3], "A2");
}

// A point of reference has a number, too, and is no pose; a repeat has one behind the pose's.
TEST_F(ImportJoined, NamesThatHoldMoreThanAPosesAmongSuchThatDoNot) {
  Table points = Points(), poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "config", [](size_t row) { return std::to_string(row + 1); });
  for (size_t r = 0; r < points.rows.size(); ++r) points.rows[r][0] = std::to_string(r + 1);
  for (const char* name : {"REF_1", "TB-3", "4_check"}) points.rows.push_back({name, "1.5", "2.5", "3.5"});
  ExpectRight(points.ToText(), Readings(), With(poses.ToText()));
  const test::Outcome outcome = ImportText(points.ToText(), With(poses.ToText()));
  EXPECT_NE(outcome.out.find("3 readings, which are left out: 'REF_1', 'TB-3' and '4_check'"), std::string::npos)
      << outcome.out;
}

// Both columns name poses and are numbers: that of the same header counts; without one they contradict each other.
TEST_F(ImportJoined, TwoColumnsThatNamePoses) {
  Table points = Points(), poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  const auto number = [](size_t row) { return std::to_string(30 - row); };
  poses.Insert(0, "Pose", number);
  for (size_t r = 0; r < points.rows.size(); ++r) points.rows[r][0] = number(r);
  points.Insert(0, "No", [](size_t row) { return std::to_string(row + 1); });
  ExpectRefused(points.ToText(), {"export.txt:2", "names another pose of", "'No'"}, With(poses.ToText()));
  points.header[1] = "Pose";
  ExpectRight(points.ToText(), Readings(), With(poses.ToText()));
}

// In a small volume any order fits the robot within a twentieth of its reach.
TEST_F(ImportJoined, TheRobotHasToConfirmTheOrder) {
  std::vector<test::Reading> near;
  for (const test::Reading& reading : Readings()) {
    near.push_back(reading);
    for (int i = 0; i < 3; ++i) near.back().xyz_mm[i] = 500.0 + 5.0 * std::sin(7.0 * near.size() + i);
    for (double& q : near.back().q_deg) q = 30.0 + 0.01 * q;
  }
  Table points = Table(near).Reordered({6, 7, 8});
  ExpectRefused(points.ToText(), {"export.txt", "nothing says that the readings are in the order of the poses"},
                With(Table(near).Reordered({0, 1, 2, 3, 4, 5}).ToText()));
}

// Eight rows are 24 equations to nine unknowns; two are fewer than any robot needs.
TEST_F(ImportJoined, TheOrderOfFewRowsHasToBeConfirmedToo) {
  const Table all_points = Table(Readings()).Reordered({6, 7, 8}),
              all_poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  for (const size_t count : {8u, 6u}) {
    Table points = all_points, poses = all_poses;
    points.rows.resize(count), poses.rows.resize(count);
    EXPECT_EQ(ImportText(points.ToText(), With(poses.ToText())).status, 0) << count;
    std::rotate(poses.rows.begin(), poses.rows.begin() + 1, poses.rows.end());
    ExpectRefused(points.ToText(), {"in the order of the rows this robot cannot have made these readings"},
                  With(poses.ToText()));
  }
  Table points = all_points, poses = all_poses;
  points.rows.resize(3), poses.rows.resize(3);
  ExpectRefused(points.ToText(), {"so few rows (3) do not confirm it", "names of the poses"}, With(poses.ToText()));
}

// Three markers under two loads, all in mixed order: the columns are checked against the robot all the same.
TEST_F(ImportJoined, PermutedNamesUnderTwoLoadsAreRefused) {
  Table poses = Table(Readings()).Reordered({0, 1, 2, 3, 4, 5});
  poses.Insert(0, "config", PoseName);
  const std::vector<std::vector<test::Reading>> markers = {test::MakeReadings(false),
                                                           test::MakeReadings(false, KDL::Vector(-0.04, 0.02, 0.08)),
                                                           test::MakeReadings(false, KDL::Vector(0.03, -0.05, 0.06))};
  std::vector<size_t> order(180);
  std::iota(order.begin(), order.end(), size_t{0});
  std::mt19937 random(5);
  for (size_t k = order.size() - 1; k > 0; --k) std::swap(order[k], order[random() % (k + 1)]);
  for (const size_t off : {0u, 7u}) {  // names of the poses themselves, and of others
    std::string text = "Point Name,Marker,Load,X,Y,Z\n";
    for (const size_t row : order) {
      const size_t pose = row % 30, marker = row / 30 % 3, load = row / 90;
      text += PoseName((pose + off) % 30) + ",M" + std::to_string(marker + 1) + (load == 0 ? ",none" : ",L50");
      for (const double x : markers[marker][pose].xyz_mm) text += "," + test::Text(x + 0.01 * load, 9);
      text += "\n";
    }
    const test::Outcome outcome = ImportText(text, With(poses.ToText()));
    EXPECT_EQ(outcome.status, off == 0 ? 0 : 2) << outcome.out;
    const std::string& said = off == 0 ? outcome.out : outcome.err;
    EXPECT_NE(said.find(off == 0 ? "the columns fit the robot" : "this robot cannot have made these readings"),
              std::string::npos)
        << said;
  }
}

TEST_F(ImportJoined, ControllersPositionsAreComputedHoweverRounded) {
  for (const double step : {0.01, 0.1}) {
    std::vector<test::Reading> rounded = test::MakeReadings(true);
    for (test::Reading& reading : rounded) {
      for (double& x : reading.xyz_mm) x = step * std::round(x / step);
    }
    Table table{rounded};
    for (auto& row : table.rows) {
      for (size_t c = 6; c < 9; ++c) {
        char text[32];
        std::snprintf(text, sizeof text, "%.4f", std::stod(row[c]));
        row[c] = text;
      }
    }
    ExpectRefused(table.ToText(), {"they were computed, not measured"});
  }
}

TEST_F(ImportJoined, NamesOfNoPoseAsManyAsPosesAreNotJoined) {
  Table points = Points();
  for (size_t r = 0; r < points.rows.size(); ++r) points.rows[r][0] = "Q" + std::to_string(r);
  std::reverse(points.rows.begin() + 3, points.rows.end());
  ExpectRefused(points.ToText(), {"no name joins the readings with the poses", "plan7_M1"}, With(Poses()));
}

}  // namespace
}  // namespace sagitta::import_joined_test

#endif  // SAGITTA_HAVE_KDL
