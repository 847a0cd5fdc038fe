// The command around the diagnosis itself: against somebody else's simulation, and what it says of its results.
#include <gmock/gmock.h>

#include "tests/tools/program.h"

namespace sagitta::test::diagnose_command_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Rows = std::vector<std::vector<std::string>>;

// The loads of 15 published configurations, on an arm whose file states what gives way.
class SimulationColumnsTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    Write("robot.yaml", ReadAll(Published("kr270/robot.yaml")) +
                            "compliance: {A2: {k_urad_per_Nm: 0.3}, A3: {k_urad_per_Nm: 0.4}}\n");
    const Rows all = Cells(ReadAll(Published("kr270/loaded.csv")));
    Rows rows = {all[0]};
    for (size_t i = 1; i < all.size(); ++i) {
      if (all[i][Column(all, "config")][0] == 'E') rows.push_back(all[i]);
    }
    Write("loads.csv", Csv(rows));
    const std::string scene =
        "stations: {S3: {xyz_mm: [100, 200, 300], rotvec_mrad: [0, 0, 500]}}\n"
        "markers: {T1: {xyz_mm: [280, 0, -100]}, T2: {xyz_mm: [100, 100, 50]}, T3: {xyz_mm: [-100, 150, 0]}}\n";
    const std::string truth = Experiment("truth.yaml", "loads.csv", scene);
    ASSERT_EQ(Run({"simulate", truth, "--truth=" + truth, "--out=" + Path("simulated.csv"), "--sigma_mm=0"}).status, 0);
  }

  std::string Experiment(const std::string& name, const std::string& measurements, const std::string& more) const {
    return Write(name, "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [" + measurements +
                           "]\nload_point_mm: [280, 60, -150]\nnoise: {sigma_mm: 0.03}\n"
                           "estimate: {geometry: none, compliance: none}\n" +
                           more);
  }

  // Measured as the robot file says, and simulated the same, in a unit of one's own and under a name of it.
  Outcome Diagnose(double units_per_mm, const std::string& unit = "mm") const {
    Rows rows = Cells(Read("simulated.csv"));
    for (const std::string axis : {"x", "y", "z"}) {
      const int measured = Column(rows, axis + "_mm");
      rows[0].push_back("sim_" + axis + "_" + unit);
      for (size_t i = 1; i < rows.size(); ++i) {
        rows[i].push_back(std::to_string(units_per_mm * std::stod(rows[i][measured])));
      }
    }
    Write("both.csv", Csv(rows));
    return Run({"diagnose", Experiment("experiment.yaml", "both.csv", ""), "--simulation=columns"});
  }
};

// Base and markers free and the deflections known: as far as the cells are rounded.
TEST_F(SimulationColumnsTest, ThatTheFileReproducesIsSaidToBe) {
  const Outcome outcome = Diagnose(1.0);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string start = "reproduces that simulation to ";
  const size_t at = outcome.out.find(start);
  ASSERT_NE(at, std::string::npos) << outcome.out;
  EXPECT_LT(std::stod(outcome.out.substr(at + start.size())), 1e-5);
  EXPECT_THAT(outcome.out, HasSubstr("Nothing is written; --out=DIR keeps the results."));
}

TEST_F(SimulationColumnsTest, PointsAreReadInTheirUnit) {
  const Outcome outcome = Diagnose(1e-3, "m");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("reproduces that simulation to "));
}

// Two readings that are 5 mm off are all that is wrong: the stated sigma is not.
TEST_F(SimulationColumnsTest, OutliersAreNoWrongSigma) {
  const std::string truth = Path("truth.yaml");
  ASSERT_EQ(
      Run({"simulate", truth, "--truth=" + truth, "--out=" + Path("noisy.csv"), "--sigma_mm=0.03", "--seed=5"}).status,
      0);
  Rows rows = Cells(Read("noisy.csv"));
  const int z = Column(rows, "z_mm");
  for (const size_t row : {4, 31}) rows[row][z] = std::to_string(std::stod(rows[row][z]) + 5.0);
  Write("outliers.csv", Csv(rows));
  const Outcome outcome = Run({"diagnose", Experiment("experiment.yaml", "outliers.csv", "")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Verdict: noise. No effect is missing; readings are outliers.\n"));
  EXPECT_THAT(outcome.out, HasSubstr("2 outliers left out"));
}

TEST_F(SimulationColumnsTest, InMetresAreRefused) {
  const Outcome outcome = Diagnose(1e-3);
  EXPECT_EQ(outcome.status, 2);
  for (const char* words : {"both.csv:2", "sim_x_mm", "look like metres", "convert"}) {
    EXPECT_THAT(outcome.err, HasSubstr(words));
  }
  EXPECT_THAT(outcome.err, Not(HasSubstr("sim_x_m ")));  // no such column is read
}

// No campaign measures a simulation next: that its joint slips at a time makes no robot for one.
TEST_F(SimulationColumnsTest, HaveNoNextCampaign) {
  Rows rows = Cells(Read("simulated.csv"));
  rows[0].insert(rows[0].end(), {"time_s", "sim_x_mm", "sim_y_mm", "sim_z_mm"});
  for (size_t i = 1; i < rows.size(); ++i) {
    rows[i].push_back(std::to_string(60 * i));
    for (const char* measured : {"x_mm", "y_mm", "z_mm"}) rows[i].push_back(rows[i][Column(rows, measured)]);
  }
  Write("both.csv", Csv(rows));
  Write("robot.yaml", Read("robot.yaml") + "effects: [{effect: joint_slip, joint: A3, after_s: 600}]\n");
  std::filesystem::create_directory(Path("out"));
  Write("out/robot.next.yaml", "of another diagnosis");
  const Outcome outcome =
      Run({"diagnose", Experiment("experiment.yaml", "both.csv", ""), "--simulation=columns", "--out=" + Path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(Read("out/robot.extended.yaml"), HasSubstr("joint_slip"));
  EXPECT_THAT(outcome.out, HasSubstr("Of an earlier run are in " + Path("out") + ": robot.next.yaml;"));
}

class DiagnoseCommandTest : public ProgramTest {};

// The extended model is judged as calibrate judges: a diagnosis that found nothing says the same of it.
TEST_F(DiagnoseCommandTest, TheEstimateHasTheVerdictThatCalibrateWrites) {
  const std::string experiment = Published("kr270/experiment.yaml");
  const std::vector<std::string> split = {"--holdout=0.3", "--seed=1"};
  const Outcome outcome = Run({"diagnose", experiment, split[0], split[1], "--out=" + Path("diagnosed")});
  ASSERT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, Not(HasSubstr("Of an earlier run")));
  ASSERT_EQ(Run({"calibrate", experiment, split[0], split[1], "--out=" + Path("calibrated")}).status, 0);
  ASSERT_EQ(ReadJson("diagnosed/diagnosis.json")["verdict"], "consistent");
  const auto diagnosed = ReadJson("diagnosed/estimate.json"), calibrated = ReadJson("calibrated/estimate.json");
  for (const auto& [key, value] : calibrated.items()) EXPECT_TRUE(diagnosed.contains(key) || key == "agreement") << key;
  for (const char* key : {"distance_rms_mm", "distance_p95_mm", "predicted_rms_mm"}) {
    EXPECT_NEAR(diagnosed["cross_validation"][key].get<double>(), calibrated["cross_validation"][key].get<double>(),
                1e-6);
  }
  EXPECT_EQ(diagnosed["suspects"], calibrated["suspects"]);
  EXPECT_EQ(diagnosed["verdict"]["trusted"], calibrated["verdict"]["trusted"]);
  for (const auto& parameter : diagnosed["parameters"]) EXPECT_TRUE(parameter.contains("ci95_noise_only"));
  // Details open when asked to.
  const std::string report = Read("diagnosed/report.html");
  EXPECT_THAT(report, HasSubstr("<details><summary><h2>What was screened</h2></summary>"));
  EXPECT_LT(report.find("<h1>Diagnosis: consistent</h1>"), report.find("<details>"));
}

// What is found consistent has no poses to propose and nothing learnt: such files next to it are not its own.
TEST_F(DiagnoseCommandTest, FilesOfAnEarlierRunAreCalledSo) {
  std::filesystem::create_directory(Path("out"));
  Write("out/robot.learnt.yaml", "of another diagnosis");
  const Outcome outcome =
      Run({"diagnose", Published("kr270/experiment.yaml"), "--holdout=0.3", "--seed=1", "--out=" + Path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  ASSERT_EQ(ReadJson("out/diagnosis.json")["verdict"], "consistent");
  EXPECT_THAT(outcome.out, HasSubstr("Of an earlier run are in " + Path("out") + ": robot.learnt.yaml;"));
  EXPECT_EQ(Read("out/robot.learnt.yaml"), "of another diagnosis");  // kept: it may be in use
}

// A spring that pulls with the weight of an arm on a track, by a simulation that shares no code with the model. Near
// the shape that the linear evidence suggests the refit has an optimum that is no better than no spring: noise other
// than stated was the answer, with certainty.
TEST_F(DiagnoseCommandTest, ASpringWhoseFirstRefitFailsIsNotRefuted) {
  const std::string campaign = SourceFolder() + "/tests/tools/pulling_spring/experiment.yaml";
  ASSERT_EQ(Run({"diagnose", campaign, "--out=" + Path("out")}).status, 0);
  const auto diagnosis = ReadJson("out/diagnosis.json");
  ASSERT_EQ(diagnosis["steps"].size(), 1u);
  EXPECT_EQ(diagnosis["steps"][0]["effect"], "gravity_compensator");
  EXPECT_EQ(diagnosis["steps"][0]["target"], "A2");
  EXPECT_LT(diagnosis["posterior"]["noise"].get<double>(), 1e-6);
}

// Play of 17 deg that a joint drags along, poses visited twice, by a simulation that shares no code with the model. By
// the nearest listed widths, 10 and 30 deg, the rest looks like a deviation that follows the pose: with that hypothesis
// in the leading set no other width had been tried.
TEST_F(DiagnoseCommandTest, AWidthIsFoundThroughADeviationOfThePose) {
  const std::string campaign = SourceFolder() + "/tests/tools/dragged_stop/experiment.yaml";
  ASSERT_EQ(Run({"diagnose", campaign, "--out=" + Path("out")}).status, 0);
  const auto diagnosis = ReadJson("out/diagnosis.json");
  EXPECT_EQ(diagnosis["verdict"], "explained");
  ASSERT_EQ(diagnosis["steps"].size(), 1u);
  EXPECT_EQ(diagnosis["steps"][0]["effect"], "hysteresis");
  const double found = diagnosis["steps"][0]["settings"]["width_deg"];
  EXPECT_NEAR(found, 17.0, 1.5);
  const auto possible = diagnosis["steps"][0]["settings_ci95"]["width_deg"];
  EXPECT_LT(possible[0].get<double>(), std::min(found, 17.0));
  EXPECT_GT(possible[1].get<double>(), std::max(found, 17.0));
  EXPECT_LT(possible[1].get<double>() - possible[0].get<double>(), 6.0);
  EXPECT_THAT(diagnosis["steps"][0]["words"].get<std::string>(), HasSubstr("These data allow width_deg from 1"));
}

constexpr char kProposed[] = "config,marker,q1_deg,x_mm,y_mm,z_mm\nnext1,T1,10,,,\nnext2,T1,20,";

// Somebody measured the proposed poses and filled in the file where it lay.
TEST_F(DiagnoseCommandTest, ReadingsInProposedPosesAreNotReplaced) {
  std::filesystem::create_directory(Path("out"));
  const std::string filled = std::string(kProposed) + "1,2,3\n";
  Write("out/next.csv", filled);
  const Outcome outcome = Run({"diagnose", Published("kr270/experiment.yaml"), "--out=" + Path("out")});
  EXPECT_EQ(outcome.status, 2);
  for (const char* words : {"next.csv:3", "x_mm", "holds readings", "list it under measurements"}) {
    EXPECT_THAT(outcome.err, HasSubstr(words));
  }
  EXPECT_EQ(Read("out/next.csv"), filled);
  EXPECT_FALSE(Exists("out/diagnosis.json"));
}

TEST_F(DiagnoseCommandTest, ProposedPosesThatNobodyMeasuredAreRemovedWhereNoneAreProposed) {
  std::filesystem::create_directory(Path("out"));
  Write("out/next.csv", std::string(kProposed) + ",,\n");
  const Outcome outcome =
      Run({"diagnose", Published("kr270/experiment.yaml"), "--holdout=0.3", "--seed=1", "--out=" + Path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  ASSERT_TRUE(ReadJson("out/diagnosis.json")["next"].is_null());
  EXPECT_FALSE(Exists("out/next.csv"));
}

}  // namespace
}  // namespace sagitta::test::diagnose_command_test
