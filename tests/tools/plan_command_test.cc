// sagitta plan as a user runs it: what is written reads back, and what cannot be planned ends with 2 and its reason.
#include "tests/tools/program.h"

namespace sagitta::test::plan_command_test {
namespace {

class PlanCommandTest : public ProgramTest {
 protected:
  const std::string experiment_ = Published("kr270/experiment.yaml");

  std::string Cell(const std::string& text) const { return Write("cell.yaml", "schema: sagitta/cell/1\n" + text); }
  Outcome Plan(std::vector<std::string> more) const { return PlanOf(experiment_, std::move(more)); }
  Outcome PlanOf(const std::string& experiment, std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"plan", experiment, "--out=" + Path("plan"), "--pool=60", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
  void ExpectRefused(const std::vector<std::string>& arguments, const std::string& words) const {
    const Outcome outcome = Plan(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    EXPECT_FALSE(Exists("plan/plan.csv"));
  }
};

TEST_F(PlanCommandTest, WritesRowsToMeasureAndSaysWhatIsNotChecked) {
  const std::string cell = Cell("floor_mm: 900\njoints: {A2: {levels_deg: [-100, -50]}}\n");
  const Outcome outcome = Plan({"--poses=16", "--cell=" + cell});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json plan = ReadJson("plan/plan.json");
  EXPECT_EQ(plan.at("poses"), 16);
  EXPECT_NE(plan.at("infeasible_because").dump().find("is below the floor"), std::string::npos);
  EXPECT_NE(plan.at("not_checked").dump().find("lines of sight of station S1"), std::string::npos);
  EXPECT_NE(plan.at("checked").dump().find("the floor"), std::string::npos);
  for (const auto& parameter : plan.at("parameters")) {
    EXPECT_NEAR(parameter.at("ci95_half_width"), 1.959964 * parameter.at("sigma").get<double>(),
                1e-6 * parameter.at("sigma").get<double>());
  }
  const auto rows = Cells(Read("plan/plan.csv"));
  ASSERT_EQ(rows.size(), 1u + 16 * 3);
  const int q2 = Column(rows, "q2_deg");
  for (size_t r = 1; r < rows.size(); ++r) {
    const double level = std::stod(rows[r][q2]);
    EXPECT_LT(std::min(std::abs(level + 100), std::abs(level + 50)), 1e-9);
  }
  // The arm is drawn once per pose, and the table has its joint values.
  const std::string page = Read("plan/report.html");
  const size_t arms = page.find("\"kind\":\"workspace\"");
  ASSERT_NE(arms, std::string::npos);
  const size_t names = page.find("\"names\":[", arms), end = page.find(']', names);
  EXPECT_EQ(std::count(page.begin() + static_cast<long>(names), page.begin() + static_cast<long>(end), ','), 15);
  // Its own rows are candidates like any others.
  const Outcome again =
      Plan({"--poses=16", "--candidates=" + Write("own.csv", Read("plan/plan.csv")), "--cell=" + cell});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_NEAR(ReadJson("plan/plan.json").at("predicted").at("position_rms_mm"),
              plan.at("predicted").at("position_rms_mm"), 1e-5);
}

// Two of 100,000 poses are feasible. The others are found from these, so what moved is what there is to choose from.
TEST_F(PlanCommandTest, InATightCellThePlanIsChosenFromThePosesThatMoved) {
  Write("rows.csv",
        "config,marker,station,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n"
        "a,M1,S1,0,-90,90,0,10,0\na,M2,S1,0,-90,90,0,10,0\na,M3,S1,0,-90,90,0,10,0\n");
  const std::string experiment = Write(
      "experiment.yaml",
      "schema: sagitta/experiment/1\nrobot: " + Published("kr270/robot.yaml") +
          "\nmeasurements: [rows.csv]\n"
          "stations: {S1: {xyz_mm: [-500, 4200, 300], rotvec_mrad: [4, -6, 2100], instrument_mm: [500, 800, 900]}}\n"
          "markers: {M1: {xyz_mm: [280, -20, -90]}, M2: {xyz_mm: [280, 100, 50]}, M3: {xyz_mm: [270, -80, 70]}}\n"
          "noise: {sigma_mm: 0.05}\n");
  const std::string cell = Cell(
      "joints: {A1: {min_deg: -90, max_deg: 90}, A2: {levels_deg: [-140, -99.85, -56.9, -25.24, -0.01]}}\n"
      "floor_mm: 300\n"
      "stay_in: [{name: work space, min_mm: [0, -2500, 0], max_mm: [3200, 2500, 3500]}]\n"
      "keep_out:\n"
      "  - {name: table, min_mm: [1200, -2000, 0], max_mm: [3000, -1200, 900]}\n"
      "  - {name: fence, size_mm: [100, 4000, 2000], xyz_mm: [2500, 0, 2800], rpy_deg: [0, 0, 30]}\n"
      "capsules:\n"
      "  - {name: upper arm, on: A2, from_mm: [0, 0, 0], to_mm: [1250, 0, 0], radius_mm: 220}\n"
      "  - {name: tool, on: flange, from_mm: [60, 0, 0], to_mm: [250, 0, 0], radius_mm: 120}\n"
      "may_touch: [[upper arm, tool]]\n"
      "clearance_mm: 20\n"
      "tool_cone: {axis: [1, 0, 0], direction: [1, 0, -1], half_angle_deg: 70}\n"
      "sight: {S1: {min_range_mm: 500, max_range_mm: 5000, min_elevation_deg: -40, max_elevation_deg: 40}}\n"
      "reflectors: {M1: {axis: [0, 0, 1], half_angle_deg: 80}}\n");
  const Outcome outcome = Run({"plan", experiment, "--out=" + Path("plan"), "--poses=20", "--cell=" + cell, "--quiet"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json plan = ReadJson("plan/plan.json");
  EXPECT_LT(plan.at("candidates"), 10);
  EXPECT_GT(plan.at("certificate").at("efficiency"), 0.9);
  for (const auto& quick : plan.at("accuracy_over_poses")) {
    if (quick.at("poses") != 20) continue;
    EXPECT_LE(plan.at("predicted").at("position_rms_mm"), 1.001 * quick.at("position_rms_mm").get<double>());
  }
  EXPECT_NE(plan.dump().find("could be drawn that keep to the cell"), std::string::npos);
}

TEST_F(PlanCommandTest, ModelErrorOfAFormerEstimateWidensWhatIsPredicted) {
  const std::string former =
      Write("estimate.json", R"({"schema": "sagitta/estimate/1", "model_error": {"factor": 2.5}})");
  ASSERT_EQ(Plan({"--poses=16", "--model_error=" + former}).status, 0);
  const nlohmann::json predicted = ReadJson("plan/plan.json").at("predicted");
  EXPECT_DOUBLE_EQ(predicted.at("position_rms_with_model_error_mm"),
                   2.5 * predicted.at("position_rms_mm").get<double>());
  const Outcome refused = Plan({"--poses=16", "--model_error=" + Write("bare.json", "{}")});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("model_error"), std::string::npos) << refused.err;
}

TEST_F(PlanCommandTest, WhatAFormerEstimateIsOffByIsPartOfThePlan) {
  const auto former = [&](double rms, double predicted) {
    return Write("estimate.json",
                 R"({"schema": "sagitta/estimate/1", "model_error": {"factor": 1.5}, "cross_validation":
      {"rms_mm": )" + std::to_string(rms) +
                     ", \"predicted_rms_mm\": " + std::to_string(predicted) + "}}");
  };
  ASSERT_EQ(Plan({"--poses=16", "--nomove", "--model_error=" + former(0.25, 0.15)}).status, 0);
  const nlohmann::json plan = ReadJson("plan/plan.json");
  EXPECT_NEAR(plan.at("predicted").at("model_field").at("rms_mm"), 0.2, 1e-9);
  EXPECT_GT(plan.at("predicted").at("model_field").at("urad"), 10.0);
  EXPECT_GT(plan.at("predicted").at("position_rms_with_model_error_mm"),
            plan.at("predicted").at("position_rms_mm").get<double>());
  EXPECT_EQ(plan.at("parameters").dump().find("joint_harmonic"), std::string::npos);  // nobody's parameters
  // A prediction that was scaled by twice the stated noise was half of that: sqrt(0.25^2 - 0.10^2).
  std::string scaled = ReadAll(former(0.25, 0.20));
  scaled.insert(1, R"("sigma": {"scaled": true, "a_posteriori": 2.0}, )");
  ASSERT_EQ(Plan({"--poses=16", "--nomove", "--model_error=" + Write("scaled.json", scaled)}).status, 0);
  EXPECT_NEAR(ReadJson("plan/plan.json").at("predicted").at("model_field").at("rms_mm"), 0.2291288, 1e-6);
  // Points that are no farther off than predicted leave the factor.
  ASSERT_EQ(Plan({"--poses=16", "--nomove", "--model_error=" + former(0.15, 0.16)}).status, 0);
  EXPECT_FALSE(ReadJson("plan/plan.json").at("predicted").contains("model_field"));
}

TEST_F(PlanCommandTest, WhatCannotBePlannedIsNamed) {
  ExpectRefused({"--poses=2"}, "fewer readings than unknowns: 2 poses cannot determine 39 parameters");
  ExpectRefused({"--poses=16", "--cell=" + Cell("floor_mm: 9000\n")}, "the flange is below the floor");
  ExpectRefused({"--poses=16", "--cell=" + Cell("joints: {A2: {min_deg: 10}}\n")}, "joint 'A2'");
  ExpectRefused({"--poses=16", "--cell=" + Cell("flor_mm: 0\n")}, "floor_mm");
  ExpectRefused({"--poses=16", "--cell=" + Cell("sight: {S7: {}}\n")}, "S7");
  ExpectRefused(
      {"--poses=16", "--cell=" + Cell("tool_cone: {axis: [0, 0, 0], direction: [0, 0, 1], half_angle_deg: 9}\n")},
      "no length");
  const std::string head = "config,marker,station,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n";
  ExpectRefused({"--poses=16", "--candidates=" + Write("empty.csv", head)}, "empty.csv");
  ExpectRefused({"--poses=16", "--candidates=" + Path("nowhere.csv")}, "nowhere.csv");
  ExpectRefused({"--poses=16", "--tests=" + Write("no_tests.csv", head)}, "no_tests.csv");
  ExpectRefused({"--accuracy_mm=0.0001"}, "even 500 poses leave");
  ExpectRefused({"--poses=0"}, "from 1 to");
  ExpectRefused({"--poses=16", "--accuracy_mm=0.1"}, "one of --poses and --accuracy_mm");
  ExpectRefused({"--poses=16", "--criterion=Z"}, "there is no criterion 'Z'");
  ExpectRefused({"--poses=16", "--discriminate=encoder_gain/A3"}, "two effects are expected");
  ExpectRefused({"--poses=16", "--discriminate=encoder_gain/A3,encoder_gian/A2"}, "there is no effect 'encoder_gian'");
  ExpectRefused({"--poses=16", "--cell=" + Cell("urdf: {file: arm.urdf}\n")}, "arm.urdf");
  ExpectRefused({"--poses=16", "--candidates=" + Write("far.csv", head + "c1,P1,S1,0,90,0,0,0,0\n")},
                "joint A2 is above its limit (1)");
  ExpectRefused({"--poses=16", "--candidates=" + Write("few.csv", head + "c1,P1,S1,0,-90,0,0,0,0\n")},
                "16 poses are asked for and there are 1 feasible candidates");
}

// Rows of S2 are test poses and nothing else: base S2 is registered on them, so that neither its six unknowns nor what
// base S1 errs by count. Of 39 unknowns 33 are left: four poses of nine readings.
TEST_F(PlanCommandTest, AStationThatOnlyTestPosesSeeIsRegisteredThere) {
  auto rows = Cells(ReadAll(Published("kr270/geometric.csv")));
  const int station = Column(rows, "station");
  const auto with_tests_at = [&](const std::string& where) {
    auto table = rows;
    table[0].push_back("set");
    for (size_t r = 1; r < table.size(); ++r) {
      const bool is_test = table[r][station] == "S2";
      if (is_test) table[r][station] = where;
      table[r].push_back(is_test ? "validation" : "calibration");
    }
    Write("rows.csv", Csv(table));
    return Write("experiment.yaml", "schema: sagitta/experiment/1\nrobot: " + Published("kr270/robot.yaml") +
                                        "\nmeasurements: [rows.csv]\nnoise: {sigma_mm: 0.1}\n");
  };
  const auto predicted = [&] { return ReadJson("plan/plan.json").at("predicted").at("position_rms_mm").get<double>(); };
  ASSERT_EQ(PlanOf(with_tests_at("S1"), {"--poses=10", "--nomove"}).status, 0);
  const double at_s1 = predicted();
  const std::string apart = with_tests_at("S2");
  const Outcome outcome = PlanOf(apart, {"--poses=10", "--nomove"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_LT(predicted(), at_s1);
  EXPECT_GT(predicted(), 0.2 * at_s1);
  EXPECT_EQ(Read("plan/plan.json").find("base/S2"), std::string::npos);
  const Outcome refused = PlanOf(apart, {"--poses=3"});
  EXPECT_NE(refused.err.find("3 poses cannot determine 33 parameters"), std::string::npos) << refused.err;
}

TEST_F(PlanCommandTest, ALoadThatFoldsTheArmIsNamed) {
  std::string text = ReadAll(Published("kr270/robot.yaml")) + "compliance:\n  A2: {k_urad_per_Nm: 4000}\n";
  Write("robot.yaml", text);
  Write("rows.csv",
        "config,marker,station,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,load\n"
        "c1,P1,S1,0,-60,60,0,30,0,heavy\nc1,P2,S1,0,-60,60,0,30,0,heavy\nc1,P3,S1,0,-60,60,0,30,0,heavy\n");
  const std::string experiment =
      Write("experiment.yaml",
            "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [rows.csv]\nload_point_mm: [280, 0, 0]\n"
            "loads: {heavy: {mass_kg: 250}}\nnoise: {sigma_mm: 0.1}\n"
            "markers: {P1: {xyz_mm: [277, -46, -94]}, P2: {xyz_mm: [276, -48, 94]}, P3: {xyz_mm: [278, 104, -2]}}\n"
            "stations: {S1: {xyz_mm: [0, 0, 0]}}\nestimate: {compliance: [A2]}\n");
  const Outcome outcome = Run({"plan", experiment, "--poses=20", "--pool=40", "--out=" + Path("plan"), "--quiet"});
  EXPECT_EQ(outcome.status, 2) << outcome.err;
  EXPECT_NE(outcome.err.find("fold"), std::string::npos) << outcome.err;
  EXPECT_FALSE(Exists("plan/plan.csv"));
}

// Before anything was measured: what the refusal says is what a plan needs.
TEST_F(PlanCommandTest, OfARobotAloneItSaysWhatRowsAPlanNeeds) {
  const std::string robot = Write("robot.yaml", ReadAll(Published("kr270/robot.yaml")));
  const Outcome refused = Run({"plan", robot, "--poses=15", "--out=" + Path("plan"), "--quiet"});
  EXPECT_EQ(refused.status, 2);
  const std::string header = "config,marker,station,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg",
                    row = "a,M1,S1,0,0,0,0,0,0";
  const std::vector<std::string> lines = {"schema: sagitta/experiment/1", "robot: robot.yaml",
                                          "measurements: [rows.csv]", "markers: {M1: {xyz_mm: [0, 0, 100]}}",
                                          "noise: {sigma_mm: 0.05}"};
  std::string experiment;
  for (const std::string& text : lines) experiment += text + "\n";
  for (const std::string& text : lines) EXPECT_NE(refused.err.find("'" + text + "'"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("'" + header + "', below it '" + row + "'"), std::string::npos) << refused.err;
  Write("rows.csv", header + "\n" + row + "\n");
  const Outcome planned =
      Run({"plan", Write("plan.yaml", experiment), "--poses=15", "--out=" + Path("plan"), "--quiet"});
  EXPECT_EQ(planned.status, 0) << planned.err;
  EXPECT_NE(Read("plan/plan.csv").find("plan15,M1,S1,"), std::string::npos);
}

}  // namespace
}  // namespace sagitta::test::plan_command_test
