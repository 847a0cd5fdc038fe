// Bad loads: named, explained, nothing half-written.
#include <gmock/gmock.h>

#include <functional>

#include "tests/tools/program.h"

namespace sagitta::test::load_input_test {
namespace {

using ::testing::HasSubstr;
using Rows = std::vector<std::vector<std::string>>;

constexpr const char* kLoaded = "kr270/loaded.csv";

void Set(const std::string& column, const std::string& value, const std::function<bool(size_t)>& which, Rows* rows) {
  const int c = Column(*rows, column);
  for (size_t i = 1; i < rows->size(); ++i) {
    if (which(i)) (*rows)[i][c] = value;
  }
}

class LoadInputTest : public ProgramTest {
 protected:
  // Loaded and unloaded rows of the 15 published configurations, three flange markers.
  Rows LoadedRows() const {
    const Rows all = Cells(ReadAll(Published(kLoaded)));
    Rows rows = {all[0]};
    for (size_t i = 1; i < all.size(); ++i) {
      if (all[i][Column(all, "config")][0] == 'E') rows.push_back(all[i]);
    }
    return rows;
  }
  std::string Robot(const std::string& more = "") const {
    return Write("robot.yaml", ReadAll(Published("kr270/robot.yaml")) + more);
  }
  Outcome Calibrate(const std::string& experiment, const Rows& rows, const std::string& robot_more = "") const {
    Robot(robot_more);
    Write("loads.csv", Csv(rows));
    const std::string head = "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [loads.csv]\n";
    return Run({"calibrate", Write("experiment.yaml", head + experiment), "--out=" + Path("out")});
  }
  void ExpectNothingWritten(const Outcome& outcome, int status, const std::vector<std::string>& words) const {
    EXPECT_EQ(outcome.status, status) << outcome.err;
    for (const std::string& word : words) EXPECT_THAT(outcome.err, HasSubstr(word));
    for (const char* file : {"estimate.json", "robot.calibrated.yaml", "residuals.csv", "report.html"}) {
      EXPECT_FALSE(Exists(std::string("out/") + file)) << file;
    }
  }
};

constexpr const char* kScene = "load_point_mm: [280, 60, -150]\nnoise: {sigma_mm: 0.03}\n";

TEST_F(LoadInputTest, GoodLoadsPass) {
  const Outcome outcome = Calibrate(kScene, LoadedRows());
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(Exists("out/estimate.json"));
}

TEST_F(LoadInputTest, WeightsAtAStationThatIsNotLevelled) {
  const std::string tilted = "stations: {S3: {levelled: false}}\n";
  const std::string tool = "tool: {mass_kg: 20, com_mm: [0, 0, 100]}\n";
  EXPECT_EQ(Calibrate(kScene + tilted, LoadedRows()).status, 0);  // forces stated in the rows need no gravity
  std::filesystem::remove_all(Path("out"));
  ExpectNothingWritten(Calibrate(kScene + tilted + tool, LoadedRows()), 2, {"stations.S3.levelled", "frame: base"});
  const std::string gravity = "gravity: {direction: [0, 0, -1], frame: base}\n";
  EXPECT_EQ(Calibrate(kScene + tilted + tool + gravity, LoadedRows()).status, 0);
}

TEST_F(LoadInputTest, LoadWithoutAPoint) {
  ExpectNothingWritten(Calibrate("noise: {sigma_mm: 0.03}\n", LoadedRows()), 2,
                       {"loads.csv:", "V250", "load_point_mm", "--load_point_mm"});
}

TEST_F(LoadInputTest, LoadWithoutAForce) {
  Rows rows = LoadedRows();
  for (const char* column : {"fx_N", "fy_N", "fz_N"})
    Set(
        column, "0", [](size_t) { return true; }, &rows);
  ExpectNothingWritten(Calibrate(kScene, rows), 2, {"loads.csv:", "V250", "has no force", "mass_kg"});
}

// An estimate knows more stations than rows have that it is compared with: why these are far off is said all the same.
TEST_F(LoadInputTest, RowsOfOneStationOfSeveralThatTheRobotDidNotMake) {
  const std::string stations = "stations: {S1: {levelled: true}, S2: {levelled: true}, S3: {levelled: true}}\n";
  const Rows published = Cells(ReadAll(Published(kLoaded)));
  Rows all = {published[0]};  // without the markers on foot and links
  for (size_t i = 1; i < published.size(); ++i) {
    if (published[i][Column(published, "config")][0] != 'G') all.push_back(published[i]);
  }
  const Outcome calibrated = Calibrate(kScene + stations, all);
  ASSERT_EQ(calibrated.status, 0) << calibrated.err;
  Rows rows = LoadedRows();  // of S3 alone
  Set(
      "x_mm", "100", [](size_t) { return true; }, &rows);
  Write("s3.csv", Csv(rows));
  const Outcome outcome = Run({"validate", Path("out/estimate.json"), Path("s3.csv"), "--out=" + Path("v")});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("cannot have made these readings"));
}

TEST_F(LoadInputTest, WrenchColumnInTheWrongUnit) {
  Rows rows = LoadedRows();
  rows[0][Column(rows, "fx_N")] = "fx_kN";
  ExpectNothingWritten(Calibrate(kScene, rows), 2, {"loads.csv:1", "fx_kN", "fx_N"});
}

TEST_F(LoadInputTest, WrenchOnSomeMarkersOfAShotOnly) {
  Rows rows = LoadedRows();
  const int marker = Column(rows, "marker"), load = Column(rows, "load");
  Set(
      "fz_N", "0", [&](size_t i) { return rows[i][marker] == "T2" && rows[i][load] == "V250"; }, &rows);
  ExpectNothingWritten(Calibrate(kScene, rows), 2, {"loads.csv:", "load", "some markers of a shot only"});
}

TEST_F(LoadInputTest, LoadStateOnSomeMarkersOfAShotOnly) {
  const Rows all = LoadedRows();
  const int config = Column(all, "config"), marker = Column(all, "marker"), load = Column(all, "load");
  Rows rows = {all[0]};
  for (size_t i = 1; i < all.size(); ++i) {  // E03: T1 unloaded, T2 and T3 loaded
    const bool is_first = all[i][marker] == "T1", is_loaded = all[i][load] != "none";
    if (all[i][config] != "E03" || is_first != is_loaded) rows.push_back(all[i]);
  }
  ExpectNothingWritten(Calibrate(kScene, rows), 2, {"loads.csv:", "V250", "E03", "some markers"});
}

TEST_F(LoadInputTest, ComplianceWithoutALoadedRow) {
  Rows all = LoadedRows(), rows = {all[0]};
  for (size_t i = 1; i < all.size(); ++i) {
    if (all[i][Column(all, "load")] == "none") rows.push_back(all[i]);
  }
  ExpectNothingWritten(Calibrate(std::string(kScene) + "estimate: {compliance: [A2]}\n", rows), 2,
                       {"estimate.compliance", "no row is loaded"});
}

TEST_F(LoadInputTest, CompensatorWhoseSpringHasNoLength) {
  // Lever and anchor coincide at q2 = -90 deg: a_x = L, a_y = 0.
  const std::string spring =
      "gravity_compensator: {joint: A2, type: spring, L_mm: 200, a_x_mm: 200, a_y_mm: 0, "
      "s0_mm: 100, Kc_N_per_mm: 100}\n";
  Rows rows = LoadedRows();
  Set(
      "q2_deg", "-90", [&](size_t i) { return rows[i][Column(rows, "config")] == "E07"; }, &rows);
  ExpectNothingWritten(Calibrate(kScene, rows, spring), 2, {"gravity_compensator", "no length", "E07"});
  std::string negative = spring;
  negative.replace(negative.find("s0_mm: 100"), 10, "s0_mm: -10");
  ExpectNothingWritten(Calibrate(kScene, LoadedRows(), negative), 2, {"robot.yaml:", "gravity_compensator", "above 0"});
}

TEST_F(LoadInputTest, LoadThatFoldsTheArm) {
  // rad instead of urad: the arm would turn by radians.
  const std::string soft = "compliance: {A2: {k_urad_per_Nm: 302}, A3: {k_urad_per_Nm: 416}}\n";
  const std::string held = "estimate: {compliance: none}\n";
  ExpectNothingWritten(Calibrate(std::string(kScene) + held, LoadedRows(), soft), 3,
                       {"equilibrium_diverged", "load 'V250' at configuration 'E", "loads.csv:", "folds the arm"});
  const Outcome inspected = Run({"inspect", Path("experiment.yaml"), "--out=" + Path("seen")});
  EXPECT_THAT(inspected.out, HasSubstr("load 'V250' at configuration 'E"));
  EXPECT_EQ(inspected.out.find("nan"), std::string::npos);
  EXPECT_EQ(inspected.err.find("trust_region"), std::string::npos);  // Ceres' own words
}

TEST_F(LoadInputTest, OnlyLoadedRowsAreAWarning) {
  Rows all = LoadedRows(), rows = {all[0]};
  for (size_t i = 1; i < all.size(); ++i) {
    if (all[i][Column(all, "load")] != "none") rows.push_back(all[i]);
  }
  const Outcome outcome = Calibrate(std::string(kScene) + "estimate: {compliance: [A2, A3]}\n", rows);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("every row is loaded"));
  EXPECT_THAT(Read("out/report.html"), HasSubstr("every row is loaded"));
  EXPECT_THAT(ReadJson("out/estimate.json")["warnings"].dump(), HasSubstr("every row is loaded"));
}

TEST_F(LoadInputTest, NamesOfLoadsThatNoRowHas) {
  const std::string typo = std::string(kScene) + "loads: {v-250: {mass_kg: 250}}\n";
  ExpectNothingWritten(Calibrate(typo, LoadedRows()), 2, {"experiment.yaml:6", "loads.v-250", "did you mean 'V250'"});
  const Outcome another = Calibrate(std::string(kScene) + "loads: {later: {mass_kg: 100}}\n", LoadedRows());
  EXPECT_EQ(another.status, 0) << another.err;
  EXPECT_THAT(another.out, HasSubstr("no row has the load 'later'"));
}

TEST_F(LoadInputTest, MassAgainstTheWrenchColumns) {
  const std::string other = std::string(kScene) + "loads: {V250: {mass_kg: 280}}\n";
  const Outcome outcome = Calibrate(other, LoadedRows());
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("280 kg"));
  EXPECT_THAT(outcome.out, HasSubstr("the columns count"));
  const Outcome same = Calibrate(std::string(kScene) + "loads: {V250: {mass_kg: 250}}\n", LoadedRows());
  EXPECT_EQ(same.out.find("the columns count"), std::string::npos);
}

TEST_F(LoadInputTest, ValuesThatNoSpringOrJointHas) {
  ExpectNothingWritten(Calibrate(kScene, LoadedRows(), "compliance: {A2: {k_urad_per_Nm: -0.3}}\n"), 2,
                       {"robot.yaml:36", "compliance.A2.k_urad_per_Nm", "not below 0"});
  const std::string head = "gravity_compensator: {joint: A2, type: spring, L_mm: 184.7, a_x_mm: 686, a_y_mm: 123, ";
  ExpectNothingWritten(Calibrate(kScene, LoadedRows(), head + "s0_mm: -458, Kc_N_per_mm: 110}\n"), 2,
                       {"robot.yaml:36", "gravity_compensator", "s0"});
  ExpectNothingWritten(Calibrate(kScene, LoadedRows(), head + "s0_mm: 458, Kc_N_per_mm: -110}\n"), 2,
                       {"robot.yaml:36", "gravity_compensator", "Kc"});
}

TEST_F(LoadInputTest, PriorsBelowTheBound) {
  const std::string prior = std::string(kScene) + "priors: {compliance/A3: {value: -0.3, sigma: 0.1}}\n";
  ExpectNothingWritten(Calibrate(prior, LoadedRows()), 2,
                       {"experiment.yaml:6", "priors.compliance/A3", "not negative"});
}

TEST_F(LoadInputTest, JointsAndParametersThatAreMisspelt) {
  ExpectNothingWritten(Calibrate(std::string(kScene) + "estimate:\n  compliance: [A2, A7]\n", LoadedRows()), 2,
                       {"experiment.yaml:7", "estimate.compliance", "A7", "A1"});
  ExpectNothingWritten(Calibrate(std::string(kScene) + "priors: {complianc/A3: {value: 1, sigma: 1}}\n", LoadedRows()),
                       2, {"experiment.yaml:6", "did you mean 'compliance/A3'"});
}

// All forces reversed: a contradiction, not a crash and not a silent answer.
TEST_F(LoadInputTest, ForcesOfTheWrongSign) {
  Rows rows = LoadedRows();
  for (const char* column : {"fx_N", "fy_N", "fz_N"}) {
    const int c = Column(rows, column);
    for (size_t i = 1; i < rows.size(); ++i) rows[i][c] = std::to_string(-std::stod(rows[i][c]));
  }
  const Outcome outcome = Calibrate(kScene, rows);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("stands on its bound"));
  EXPECT_THAT(outcome.out, HasSubstr("sign"));
  // What does not fit because a compliance may not be negative is no noise by which it could be.
  const std::string verdict = ReadJson("out/estimate.json")["verdict"].dump();
  EXPECT_THAT(verdict, HasSubstr("comes out negative"));
  EXPECT_THAT(verdict, ::testing::Not(HasSubstr("contradict each other")));
  bool any_at_zero = false;
  const auto estimate = ReadJson("out/estimate.json");
  for (const auto& row : estimate["parameters"]) {
    if (row["name"].get<std::string>().rfind("compliance/", 0) != 0) continue;
    EXPECT_GE(row["value"], 0.0);
    any_at_zero = any_at_zero || (row["value"] == 0.0 && row["at_bound"] == true);
  }
  EXPECT_TRUE(any_at_zero);
  const Outcome inspected = Run({"inspect", Path("experiment.yaml"), "--out=" + Path("seen")});
  EXPECT_EQ(inspected.status, 0);
  EXPECT_THAT(ReadJson("seen/inspect.json").dump(), HasSubstr("move against its force"));
}

TEST_F(LoadInputTest, ForcesInTheWrongUnit) {
  for (const double factor : {1e-3, 1e3}) {
    Rows rows = LoadedRows();
    for (const char* column : {"fx_N", "fy_N", "fz_N"}) {
      const int c = Column(rows, column);
      for (size_t i = 1; i < rows.size(); ++i) rows[i][c] = std::to_string(factor * std::stod(rows[i][c]));
    }
    Calibrate(kScene, rows);
    const Outcome inspected = Run({"inspect", Path("experiment.yaml"), "--out=" + Path("seen")});
    EXPECT_THAT(ReadJson("seen/inspect.json").dump(),
                HasSubstr(factor < 1.0 ? "no arm is that soft" : "no arm is that stiff"));
  }
  Calibrate(kScene, LoadedRows());
  const Outcome right = Run({"inspect", Path("experiment.yaml"), "--out=" + Path("seen")});
  EXPECT_EQ(right.status, 0);
  const std::string seen = ReadJson("seen/inspect.json").dump();
  EXPECT_EQ(seen.find("load_unit"), std::string::npos);
  EXPECT_EQ(seen.find("load_sign"), std::string::npos);
}

TEST_F(LoadInputTest, APlanAcceptsThePointThatItAsksFor) {
  Robot();
  Write("loads.csv", Csv(LoadedRows()));
  std::vector<std::string> line = {"plan",      Path("robot.yaml"), Path("loads.csv"),      "--poses=30",
                                   "--pool=60", "--sigma_mm=0.03",  "--out=" + Path("plan")};
  const Outcome asked = Run(line);
  EXPECT_EQ(asked.status, 2);
  EXPECT_THAT(asked.err, HasSubstr("--load_point_mm=x,y,z"));
  line.push_back("--load_point_mm=280,60,-150");
  const Outcome answered = Run(line);
  EXPECT_EQ(answered.status, 0) << answered.err;
  EXPECT_TRUE(Exists("plan/plan.csv"));
}

}  // namespace
}  // namespace sagitta::test::load_input_test
