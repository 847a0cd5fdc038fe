// What a plan writes and is judged by: columns that its own file needs, the order of its rows, the points that count.
#include "tests/tools/program.h"

namespace sagitta::test::plan_rows_test {
namespace {

class PlanRowsTest : public ProgramTest {
 protected:
  // The experiment of a KR 270 with these effects and these columns of each row of its eight poses, by number.
  template <typename CellsOf>
  std::string ExperimentOf(const std::string& effects, const std::string& columns, const CellsOf& cells_of) const {
    Write("robot.yaml", ReadAll(Published("kr270/robot.yaml")) + (effects.empty() ? "" : "effects:\n") + effects);
    std::string rows = "config,marker,station,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg" + columns + "\n";
    for (int c = 0; c < 8; ++c) {
      for (const char* marker : {"M1", "M2", "M3"}) {
        rows += "c" + std::to_string(c) + "," + marker + ",S1," + std::to_string(12 * c - 40) + ",-90," +
                std::to_string(90 - 8 * c) + ",0,10," + std::to_string(15 * c) + cells_of(c) + "\n";
      }
    }
    Write("rows.csv", rows);
    return Write(
        "experiment.yaml",
        "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [rows.csv]\n"
        "stations: {S1: {xyz_mm: [-500, 4200, 300], rotvec_mrad: [4, -6, 2100]}}\n"
        "markers: {M1: {xyz_mm: [280, -20, -90]}, M2: {xyz_mm: [280, 100, 50]}, M3: {xyz_mm: [270, -80, 70]}}\n"
        "noise: {sigma_mm: 0.05}\n" +
            std::string(effects.empty() ? "" : "estimate: {effects: all}\n"));
  }
  Outcome PlanOf(const std::string& experiment, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"plan",     experiment,   "--out=" + Path("plan"),
                                          "--nomove", "--pool=100", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
  double Predicted() const { return ReadJson("plan/plan.json").at("predicted").at("position_rms_mm"); }
  double SigmaOf(const std::string& name) const {
    const nlohmann::json plan = ReadJson("plan/plan.json");
    for (const auto& parameter : plan.at("parameters")) {
      if (parameter.at("name").get<std::string>().find(name) != std::string::npos) return parameter.at("sigma");
    }
    ADD_FAILURE() << "no parameter " << name;
    return 0.0;
  }
};

// Heat that follows the thermometer late needs the time too.
TEST_F(PlanRowsTest, AnEffectFindsItsColumnsInThePlan) {
  const std::string experiment =
      ExperimentOf("  - {effect: thermal_growth, lag_s: 1200}\n", ",time_s,temperature_degC",
                   [](int c) { return "," + std::to_string(600 * c) + "," + std::to_string(20 + c); });
  const Outcome outcome = PlanOf(experiment, {"--poses=16"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto rows = Cells(Read("plan/plan.csv"));
  for (size_t r = 1; r < rows.size(); ++r) {
    EXPECT_NEAR(20 + std::stod(rows[r][Column(rows, "time_s")]) / 600,
                std::stod(rows[r][Column(rows, "temperature_degC")]), 1e-9);
  }
  EXPECT_NE(Read("plan/plan.json").find("Effects of the robot go with time and temperature"), std::string::npos);
  const std::string own = Write("own.csv", Read("plan/plan.csv"));
  const Outcome again = PlanOf(experiment, {"--poses=16", "--candidates=" + own});
  EXPECT_EQ(again.status, 0) << again.err;
}

// Hysteresis makes of a pose what the way there makes of it: what is promised is what a calibration of rows in the
// order of plan.csv finds, whose sigma goes by the same readings and the values that it found.
TEST_F(PlanRowsTest, APlanIsJudgedInTheOrderThatItWrites) {
  const std::string experiment = ExperimentOf("  - {effect: hysteresis, joint: A2, width_deg: 8, amplitude_urad: 50}\n",
                                              ",time_s", [](int c) { return "," + std::to_string(600 * c); });
  ASSERT_EQ(PlanOf(experiment, {"--poses=20"}).status, 0);
  EXPECT_NE(Read("plan/plan.json").find("hysteresis[width_deg=8]/A2"), std::string::npos);
  std::string text = Read("experiment.yaml");
  text.replace(text.find("rows.csv"), 8, "plan/plan.csv");
  const std::string planned = Write("planned.yaml", text);
  ASSERT_EQ(Run({"simulate", planned, "--out=" + Path("measured.csv")}).status, 0);
  text.replace(text.find("plan/plan.csv"), 13, "measured.csv");
  ASSERT_EQ(Run({"calibrate", Write("measured.yaml", text), "--out=" + Path("found"), "--quiet"}).status, 0);
  int compared = 0;
  const nlohmann::json found = ReadJson("found/estimate.json");
  for (const auto& parameter : found.at("parameters")) {
    const std::string name = parameter.at("name");
    if (name.find("hysteresis") == std::string::npos) continue;
    EXPECT_NEAR(SigmaOf("hysteresis"), parameter.at("sigma"), 0.02 * parameter.at("sigma").get<double>());
    ++compared;
  }
  EXPECT_EQ(compared, 1);
  // With rows that are measured already it goes on after them.
  Write("rows.csv", Read("measured.csv"));
  const Outcome more = PlanOf(experiment, {"--poses=5", "--augment"});
  EXPECT_EQ(more.status, 0) << more.err;
}

// Registering a station of its own on one pose or two follows whatever is read there.
TEST_F(PlanRowsTest, TestsThatRegisteringUsesUpAreNone) {
  const std::string experiment = ExperimentOf("", "", [](int) { return ""; });
  const std::string head = "config,marker,station,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n";
  const auto tests_of = [&](int poses, const std::string& also) {
    std::string rows = head + also;
    for (int t = 0; t < poses; ++t) {
      rows += "t" + std::to_string(t) + ",M1,S9," + std::to_string(25 * t - 60) + ",-80," + std::to_string(70 + 4 * t) +
              "," + std::to_string(30 * t) + ",20,5\n";
    }
    return "--tests=" + Write("tests.csv", rows);
  };
  for (const int poses : {1, 2}) {
    for (const char* wish : {"--poses=12", "--accuracy_mm=0.1"}) {
      const Outcome refused = PlanOf(experiment, {wish, tests_of(poses, "")});
      EXPECT_EQ(refused.status, 2);
      EXPECT_NE(refused.err.find("6 unknowns, and the test points " + std::to_string(3 * poses) + " coordinates"),
                std::string::npos)
          << refused.err;
    }
  }
  // Next to others they do not count.
  const std::string known = "k1,M1,S1,10,-70,60,5,20,5\nk2,M2,S1,-30,-90,80,5,20,50\n";
  ASSERT_EQ(PlanOf(experiment, {"--poses=12", tests_of(0, known)}).status, 0);
  const double expected = Predicted();
  ASSERT_EQ(PlanOf(experiment, {"--poses=12", tests_of(2, known)}).status, 0);
  EXPECT_NEAR(Predicted(), expected, 1e-3 * expected);
  EXPECT_EQ(ReadJson("plan/plan.json").at("test_points"), 2);
  EXPECT_NE(Read("plan/plan.json").find("6 unknowns leave nothing of the 6 coordinates there"), std::string::npos);
  // Of four poses half of the coordinates are left, of very many nearly all: the error per coordinate that is left
  // depends on the poses and not on how many there are.
  const auto errors_of = [&](int poses) {
    EXPECT_EQ(PlanOf(experiment, {"--poses=12", tests_of(poses, "")}).status, 0);
    return Predicted();
  };
  const double of_few = errors_of(4), of_many = errors_of(6);
  EXPECT_NE(Read("plan/plan.json").find("of the 18 coordinates there 12 are left"), std::string::npos);
  EXPECT_GT(of_few, 0.5 * of_many);
  EXPECT_LT(of_few, 2.0 * of_many);
  const nlohmann::json predicted = ReadJson("plan/plan.json").at("predicted");
  EXPECT_GE(predicted.at("position_max_mm"), predicted.at("position_rms_mm"));
}

}  // namespace
}  // namespace sagitta::test::plan_rows_test
