// Bad input ends with 2, names the file and the matter, and leaves nothing.
#include <cmath>
#include <functional>

#include "tests/tools/program.h"

namespace sagitta::test::bad_input_test {
namespace {

using Rows = std::vector<std::vector<std::string>>;

struct BadFile {
  std::string name;
  std::function<void(Rows*)> spoil;
  std::vector<std::string> words;  // on stderr
  std::vector<std::string> flags;
};

void PrintTo(const BadFile& file, std::ostream* stream) { *stream << file.name; }

void Rename(const std::string& from, const std::string& to, Rows* rows) { (*rows)[0][Column(*rows, from)] = to; }

void Append(const std::string& name, const std::string& value, Rows* rows) {
  for (auto& row : *rows) row.push_back(value);
  (*rows)[0].back() = name;
}

void Remove(const std::string& name, Rows* rows) {
  const int c = Column(*rows, name);
  for (auto& row : *rows) row.erase(row.begin() + c);
}

void Keep(const std::string& column, const std::string& value, Rows* rows) {
  const int c = Column(*rows, column);
  Rows kept = {(*rows)[0]};
  for (const auto& row : *rows) {
    if (row[c] == value) kept.push_back(row);
  }
  *rows = kept;
}

// Everything with `value` in `column` becomes validation.
void Validate(const std::string& column, const std::string& value, Rows* rows) {
  const int c = Column(*rows, column);
  Append("set", "calibration", rows);
  for (auto& row : *rows) {
    if (row[c] == value) row.back() = "validation";
  }
}

// The configurations of station S2 get names of their own.
void SeparateStations(Rows* rows) {
  for (auto& row : *rows) {
    if (row[Column(*rows, "station")] == "S2") row[Column(*rows, "config")] += "b";
  }
}

// Every configuration is where the first one is.
void StandStill(Rows* rows) {
  for (int j = 1; j <= 6; ++j) {
    const int c = Column(*rows, "q" + std::to_string(j) + "_deg");
    for (size_t i = 2; i < rows->size(); ++i) (*rows)[i][c] = (*rows)[1][c];
  }
}

void ScaleJoints(double factor, Rows* rows) {
  for (int j = 1; j <= 6; ++j) {
    const int c = Column(*rows, "q" + std::to_string(j) + "_deg");
    for (size_t i = 1; i < rows->size(); ++i) (*rows)[i][c] = std::to_string(factor * std::stod((*rows)[i][c]));
  }
}

std::vector<BadFile> BadFiles() {
  constexpr double kRadians = 3.14159265358979323846 / 180.0;
  return {
      {"missing_column", [](Rows* r) { Remove("z_mm", r); }, {"z_mm"}, {}},
      {"misspelt_column", [](Rows* r) { Rename("station", "staton", r); }, {"staton", "station"}, {}},
      {"wrong_unit_suffix", [](Rows* r) { Rename("x_mm", "x_cm", r); }, {"x_cm", "x_mm"}, {}},
      {"joint_in_mm", [](Rows* r) { Rename("q2_deg", "q2_mm", r); }, {"q2_mm", "q2_deg"}, {}},
      {"not_a_number", [](Rows* r) { (*r)[3][Column(*r, "y_mm")] = "nan"; }, {":4: y_mm"}, {}},
      {"infinite", [](Rows* r) { (*r)[3][Column(*r, "y_mm")] = "inf"; }, {":4: y_mm"}, {}},
      {"text", [](Rows* r) { (*r)[3][Column(*r, "q1_deg")] = "ten"; }, {":4: q1_deg", "ten"}, {}},
      {"sigma_of_zero",
       [](Rows* r) {
         for (const char* axis : {"sigma_x_mm", "sigma_y_mm", "sigma_z_mm"}) Append(axis, "0.1", r);
         (*r)[2].back() = "0";
       },
       {":3: sigma_z_mm"},
       {}},
      {"duplicate_rows", [](Rows* r) { r->push_back(r->back()); }, {}, {}},
      {"joints_differ_within_a_visit", [](Rows* r) { (*r)[2][Column(*r, "q3_deg")] = "1.5"; }, {"C01"}, {}},
      {"one_configuration_only",
       [](Rows* r) { Keep("config", "C01", r); },
       {"configuration"},
       {"--free=geometry/p_x1"}},
      {"all_configurations_alike", StandStill, {"config", "18 configurations are alike"}, {"--validation=none"}},
      {"all_configurations_alike_and_held_out",
       StandStill,
       {"validation", "configurations are alike"},
       {"--holdout=0.3"}},
      {"fewer_equations_than_unknowns", [](Rows* r) { r->resize(5); }, {}, {}},
      {"joint_count", [](Rows* r) { Remove("q6_deg", r); }, {"6 joints", "q5"}, {}},
      {"validation_only_station",
       [](Rows* r) {
         SeparateStations(r);
         Validate("station", "S2", r);
       },
       {"station", "S2"},
       {}},
      {"radians_in_degree_columns", [](Rows* r) { ScaleJoints(kRadians, r); }, {"q1_deg", "q1_rad", "radians"}, {}},
      {"absent_validation_column", [](Rows*) {}, {"grupp"}, {"--validation=grupp=a"}},
      {"empty", [](Rows* r) { r->clear(); }, {}, {}},
      {"header_only", [](Rows* r) { r->resize(1); }, {}, {}},
  };
}

class BadInputTest : public ProgramTest {
 protected:
  void ExpectRefused(const Outcome& outcome, const std::vector<std::string>& words) const {
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    for (const std::string& word : words)
      EXPECT_NE(outcome.err.find(word), std::string::npos) << word << "\n" << outcome.err;
    for (const char* file : {"estimate.json", "robot.calibrated.yaml", "residuals.csv", "report.html"}) {
      EXPECT_FALSE(Exists(std::string("out/") + file)) << file;
    }
  }
};

class BadFileTest : public BadInputTest, public ::testing::WithParamInterface<BadFile> {};

TEST_P(BadFileTest, IsRefusedWithFileAndMatter) {
  Rows rows = Cells(ReadAll(Published("kr270/geometric.csv")));
  GetParam().spoil(&rows);
  const std::string file = Write(GetParam().name + ".csv", Csv(rows));
  std::vector<std::string> arguments = {"calibrate", Published("kr270/robot.yaml"), file, "--out=" + Path("out")};
  for (const std::string& flag : GetParam().flags) arguments.push_back(flag);
  std::vector<std::string> words = GetParam().words;
  words.push_back(GetParam().name + ".csv");
  ExpectRefused(Run(arguments), words);
}

INSTANTIATE_TEST_SUITE_P(Kr270, BadFileTest, ::testing::ValuesIn(BadFiles()),
                         [](const auto& param_info) { return param_info.param.name; });

TEST_F(BadInputTest, UnknownKeyOfRobotAndExperiment) {
  std::string robot = ReadAll(Published("kr270/robot.yaml"));
  robot.replace(robot.find("kinematics:"), 11, "kinematic:");
  ExpectRefused(Run({"calibrate", Write("odd.yaml", robot), Published("kr270/geometric.csv"), "--out=" + Path("out")}),
                {"odd.yaml", "kinematics"});
  const std::string experiment =
      Write("exp.yaml", "schema: sagitta/experiment/1\nrobbot: r.yaml\nmeasurements: [a.csv]\n");
  ExpectRefused(Run({"calibrate", experiment, "--out=" + Path("out")}), {"exp.yaml:2", "robot"});
}

// Joints of one kind have their repeatability in an angle, those of the other in a length.
TEST_F(BadInputTest, RepeatabilityOfTheWrongKind) {
  const std::string head = "schema: sagitta/experiment/1\nrobot: " + Published("kr270/robot.yaml") +
                           "\nmeasurements: [" + Published("kr270/geometric.csv") + "]\nnoise: {sigma_mm: 0.1}\n";
  for (const std::string key : {"repeatability_um: 8", "repeatability_um: {A1: 8}", "repeatability_um: estimate"}) {
    ExpectRefused(Run({"calibrate", Write("exp.yaml", head + key + "\n"), "--out=" + Path("out")}),
                  {"exp.yaml", "repeatability_um", "repeatability_urad"});
  }
}

// The direction of one joint says nothing of another's play.
TEST_F(BadInputTest, ApproachOfAnotherJoint) {
  const std::string robot = Write("play.yaml", ReadAll(Published("kr270/robot.yaml")) +
                                                   "effects:\n  - {effect: backlash, joint: A3, half_gap_urad: 0}\n");
  Rows rows = Cells(ReadAll(Published("kr270/geometric.csv")));
  Append("approach1", "1", &rows);
  ExpectRefused(Run({"calibrate", robot, Write("m.csv", Csv(rows)), "--sigma_mm=0.1", "--out=" + Path("out")}),
                {"m.csv", "approach3"});
  Append("approach3", "-1", &rows);
  for (auto& row : rows) {
    if (row[0] == rows[1][0]) row.back() = "";
  }
  ExpectRefused(Run({"calibrate", robot, Write("m.csv", Csv(rows)), "--sigma_mm=0.1", "--out=" + Path("out")}),
                {"m.csv:2", "approach3"});
  for (size_t i = 1; i < rows.size(); ++i) rows[i].back() = "-1";
  EXPECT_EQ(Run({"calibrate", robot, Write("m.csv", Csv(rows)), "--sigma_mm=0.1"}).status, 0);
}

// One row of a shot states the direction of joint 3, the next does not: that of joint 1 is not to blame.
TEST_F(BadInputTest, ApproachThatOneRowOfAShotLacks) {
  Rows rows = Cells(ReadAll(Published("kr270/geometric.csv")));
  Append("approach1", "1", &rows);
  Append("approach3", "-1", &rows);
  rows[2].back() = "";
  ExpectRefused(Run({"calibrate", Published("kr270/robot.yaml"), Write("m.csv", Csv(rows)), "--out=" + Path("out")}),
                {"m.csv:3: approach3", "empty", "m.csv:2"});
  rows[2].back() = "1";
  ExpectRefused(Run({"calibrate", Published("kr270/robot.yaml"), Write("m.csv", Csv(rows)), "--out=" + Path("out")}),
                {"m.csv:3: approach3", "differs", "another visit"});
}

// To YAML it is one long text: its beginning is enough to recognise it.
TEST_F(BadInputTest, MeasurementsWhereTheRobotBelongs) {
  const std::string file = Published("kr270/geometric.csv");
  const Outcome outcome = Run({"calibrate", file, file, "--out=" + Path("out")});
  ExpectRefused(outcome, {"geometric.csv", "a map (key: value) is expected", "a robot or an experiment"});
  EXPECT_LT(outcome.err.size(), 500u);
}

TEST_F(BadInputTest, AbsentFileAndFolderForAFile) {
  const std::string robot = Published("kr270/robot.yaml");
  ExpectRefused(Run({"calibrate", robot, Path("absent.csv"), "--out=" + Path("out")}), {"absent.csv"});
  ExpectRefused(Run({"calibrate", robot, Path("."), "--out=" + Path("out")}), {});
  ExpectRefused(Run({"calibrate", Path("absent.yaml"), Published("kr270/geometric.csv")}), {"absent.yaml"});
}

TEST_F(BadInputTest, OutputFolderThatCannotBeWritten) {
  Write("file", "");
  const Outcome outcome = Run({"calibrate", Published("kr270/experiment.yaml"), "--out=" + Path("file/out")});
  ExpectRefused(outcome, {"file"});
}

TEST_F(BadInputTest, MetresInMillimetreColumns) {
  Rows rows = Cells(ReadAll(Published("kr270/geometric.csv")));
  for (const char* name : {"x_mm", "y_mm", "z_mm"}) {
    const int c = Column(rows, name);
    for (size_t i = 1; i < rows.size(); ++i) rows[i][c] = std::to_string(std::stod(rows[i][c]) / 1e3);
  }
  const std::string file = Write("metres.csv", Csv(rows));
  ExpectRefused(Run({"calibrate", Published("kr270/robot.yaml"), file, "--out=" + Path("out")}),
                {"x_mm", "x_m", "metres"});
}

TEST_F(BadInputTest, DegreesInRadianColumns) {
  Rows rows = Cells(ReadAll(Published("kr270/geometric.csv")));
  for (int j = 1; j <= 6; ++j) Rename("q" + std::to_string(j) + "_deg", "q" + std::to_string(j) + "_rad", &rows);
  const std::string file = Write("degrees.csv", Csv(rows));
  ExpectRefused(Run({"calibrate", Published("kr270/robot.yaml"), file, "--out=" + Path("out")}), {"q1_rad", "q1_deg"});
}

}  // namespace
}  // namespace sagitta::test::bad_input_test
