// sagitta plan as a user runs it: what is written reads back, and what cannot be planned ends with 2 and its reason.
#include "tests/tools/program.h"

namespace sagitta::test::plan_command_test {
namespace {

// Rows of a KR 270 before anything is measured: a pose of three markers, and where these are.
constexpr const char* kTemplateHead = "config,marker,station,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg";

// One configuration; `cells`: of further columns, with their commas.
std::string Template(const std::string& cells, const std::string& configuration = "a") {
  std::string rows;
  for (const char* marker : {"M1", "M2", "M3"}) {
    rows += configuration + "," + marker + ",S1,0,-90,90,0,10,0" + cells + "\n";
  }
  return rows;
}

class PlanCommandTest : public ProgramTest {
 protected:
  // Of rows.csv in the test's folder; `more`: further keys.
  std::string TemplateExperiment(const std::string& more) const {
    return "schema: sagitta/experiment/1\nrobot: " + Published("kr270/robot.yaml") +
           "\nmeasurements: [rows.csv]\n"
           "stations: {S1: {xyz_mm: [-500, 4200, 300], rotvec_mrad: [4, -6, 2100]}}\n"
           "markers: {M1: {xyz_mm: [280, -20, -90]}, M2: {xyz_mm: [280, 100, 50]}, M3: {xyz_mm: [270, -80, 70]}}\n" +
           more;
  }
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
                     ", \"predicted_rms_mm\": " + std::to_string(predicted) +
                     ", \"prediction_p_value\": " + (rms > predicted ? "1e-9" : "0.7") + "}}");
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

// However a former estimate came by its noise: 0.25 mm that are seen, of which a plan's sigma of 0.05 mm explains 0.05.
TEST_F(PlanCommandTest, AModelErrorThatTheFormerNoiseHoldsIsStillOne) {
  const auto field = [&](const std::string& more, double predicted) {
    const std::string former =
        Write("estimate.json", R"({"model_error": {"factor": 1.0}, "cross_validation": {"rms_mm": 0.25, )"
                               R"("predicted_rms_mm": )" +
                                   std::to_string(predicted) + "}, \"fit\": {\"dof\": 60}" + more + "}");
    const Outcome outcome = Plan({"--poses=16", "--nomove", "--sigma_mm=0.05", "--model_error=" + former});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json all = ReadJson("plan/plan.json").at("predicted");
    return all.contains("model_field") ? all.at("model_field").at("rms_mm").get<double>() : 0.0;
  };
  const double seen = std::sqrt(0.25 * 0.25 - 0.05 * 0.05);
  const std::string sigma = R"(, "sigma": {"scaled": false, "a_posteriori": )";
  EXPECT_NEAR(field(sigma + R"(1.0, "stated": false, "estimated_mm": 0.2})", 0.2), seen, 1e-9);  // not stated
  EXPECT_NEAR(field(sigma + R"(4.0, "stated": true, "p_value": 0.0})", 0.2), seen, 1e-9);        // sandwich
  EXPECT_NEAR(field(sigma + R"(1.0, "stated": true}, "noise": {"groups": [)"                     // of residuals
                            R"({"sigma_mm": 0.12, "rows": 3}, {"sigma_mm": 0.256125, "rows": 3}]})",
                    0.2),
              seen, 1e-6);
  EXPECT_NEAR(field(sigma + R"(1.1, "stated": true, "p_value": 0.2})", 0.15), 0.2, 1e-9);         // chance
  EXPECT_NEAR(field(sigma + R"(1.0, "stated": false, "estimated_mm": 0.04})", 0.15), 0.2, 1e-9);  // a better instrument
  const std::string words = "found the repeatability of the joints from its residuals";
  EXPECT_EQ(Read("plan/plan.json").find(words), std::string::npos);
  const std::string repeatability =
      R"(, "noise": {"variance": {"components": [{"name": "instrument", "estimated": true},)"
      R"( {"name": "joints", "joints": ["A1"], "estimated": true}]}})";
  EXPECT_EQ(field(repeatability, 0.2), 0.0);
  EXPECT_NE(Read("plan/plan.json").find(words), std::string::npos);
}

// What is assumed in place of what an experiment leaves to the calibration is said.
TEST_F(PlanCommandTest, ARepeatabilityToEstimateAndOtherWeightsAreSaid) {
  Write("rows.csv", std::string(kTemplateHead) + ",sigma_x_mm,sigma_y_mm,sigma_z_mm\n" + Template(",0.02,0.02,0.3"));
  const auto said = [&](const std::string& more, const std::string& words) {
    const Outcome outcome = PlanOf(Write("experiment.yaml", TemplateExperiment(more)), {"--poses=12", "--nomove"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Read("plan/plan.json").find(words) != std::string::npos;
  };
  const std::string counts_none = "nothing states it: the plan counts none", best = "The plan counts the best weights";
  EXPECT_FALSE(said("repeatability_urad: 30\n", counts_none));
  EXPECT_TRUE(said("repeatability_urad: estimate\n", counts_none));
  EXPECT_TRUE(said("noise: {from: variance-components}\n", counts_none));
  EXPECT_TRUE(said("weights: equal\n", best));
  EXPECT_FALSE(said("", best));
}

// Rows that are measured alike and state other standard deviations have on average their mean variance, whichever comes
// first; two arrivals at a pose are another way to measure it than two readings of one.
TEST_F(PlanCommandTest, ThePlanDoesNotGoByWhichRowIsFirst) {
  const std::string sigmas = ",sigma_x_mm,sigma_y_mm,sigma_z_mm";
  const auto promised = [&](const std::string& more) {
    const Outcome outcome = PlanOf(Write("experiment.yaml", TemplateExperiment(more)), {"--poses=12", "--nomove"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return ReadJson("plan/plan.json").at("predicted").at("position_rms_mm").get<double>();
  };
  const auto with_sigmas = [&](const std::string& first, const std::string& others) {
    std::string rows = kTemplateHead + sigmas + "\n";
    for (int c = 0; c < 8; ++c) rows += Template(c == 0 ? first : others, "c" + std::to_string(c));
    Write("rows.csv", rows);
    return promised("");
  };
  // sqrt((0.01^2 + 7 * 0.1^2) / 8) = 0.093608
  const double expected = with_sigmas(",0.09360822,0.09360822,0.09360822", ",0.09360822,0.09360822,0.09360822");
  EXPECT_EQ(Read("plan/plan.json").find("measured alike state standard deviations"), std::string::npos);
  EXPECT_NEAR(with_sigmas(",0.01,0.01,0.01", ",0.1,0.1,0.1"), expected, 1e-6 * expected);
  EXPECT_NE(Read("plan/plan.json").find("measured alike state standard deviations from 0.01 mm to 0.1 mm"),
            std::string::npos);
  const auto rows = Cells(Read("plan/plan.csv"));
  for (size_t r = 1; r < rows.size(); ++r) EXPECT_NEAR(std::stod(rows[r][Column(rows, "sigma_x_mm")]), 0.0936082, 1e-6);

  const auto with_visits = [&](int twice_visited) {
    std::string table = std::string(kTemplateHead) + ",visit,repeat\n";
    for (int c = 0; c < 8; ++c) {
      for (const char* number : {"1", "2"}) {
        const bool is_visit = c == twice_visited;
        table += Template(is_visit ? std::string(",v") + number + ",1" : std::string(",v1,") + number,
                          "c" + std::to_string(c));
      }
    }
    Write("rows.csv", table);
    return promised("noise: {sigma_mm: 0.05}\nrepeatability_urad: 30\n");
  };
  const double first = with_visits(0);
  EXPECT_NEAR(with_visits(7), first, 1e-3 * first);
}

// Growth with the temperature is known from poses at several, whichever the first row had, and plan.csv states which.
TEST_F(PlanCommandTest, EachPoseHasATemperatureAndATimeOfItsOwn) {
  Write("robot.yaml", ReadAll(Published("kr270/robot.yaml")) +
                          "effects:\n  - {effect: thermal_growth, growth_ppm_per_K: 12}\n"
                          "  - {effect: station_drift, station: S1}\n");
  std::string text = TemplateExperiment("noise: {sigma_mm: 0.05}\nestimate: {effects: all}\n");
  text.replace(text.find(Published("kr270/robot.yaml")), Published("kr270/robot.yaml").size(), "robot.yaml");
  const std::string experiment = Write("experiment.yaml", text);
  const auto plan_of = [&](bool turned) {
    std::string rows = std::string(kTemplateHead) + ",time_s,temperature_degC\n";
    for (int c = 0; c < 8; ++c) {
      const int k = turned ? 7 - c : c;
      rows += Template("," + std::to_string(600 * k) + "," + std::to_string(20 + k), "c" + std::to_string(k));
    }
    Write("rows.csv", rows);
    const Outcome outcome = PlanOf(experiment, {"--poses=16", "--tests=random"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json plan = ReadJson("plan/plan.json");
    for (const auto& parameter : plan.at("parameters")) {
      EXPECT_TRUE(parameter.at("identifiable")) << parameter;
    }
    return ReadJson("plan/plan.json").at("predicted").at("position_rms_mm").get<double>();
  };
  const double promised = plan_of(false);
  EXPECT_LT(promised, 0.5);
  EXPECT_NEAR(plan_of(true), promised, 0.15 * promised);  // the same conditions at other poses
  EXPECT_NE(Read("plan/plan.json").find("Effects of the robot go with time and temperature"), std::string::npos);
  const auto rows = Cells(Read("plan/plan.csv"));
  std::vector<double> times;
  for (size_t r = 1; r < rows.size(); ++r) {
    times.push_back(std::stod(rows[r][Column(rows, "time_s")]));
    EXPECT_NEAR(20 + times.back() / 600, std::stod(rows[r][Column(rows, "temperature_degC")]), 1e-9);
  }
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
  EXPECT_LT(times.front(), times.back());
}

TEST_F(PlanCommandTest, WhatCannotBePlannedIsNamed) {
  ExpectRefused({"--poses=2"}, "fewer readings than unknowns: 2 poses cannot determine 39 parameters");
  EXPECT_EQ(Plan({"--poses=2"}).err.find("--fixed"), std::string::npos);  // a flag that plan does not know
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

// What a calibration of the plan's rows goes by is what the plan counted with.
TEST_F(PlanCommandTest, RowsStateTheSigmaOfTheFlag) {
  Write("rows.csv", std::string(kTemplateHead) + ",sigma_x_mm,sigma_y_mm,sigma_z_mm\n" + Template(",0.02,0.02,0.3"));
  const std::string experiment = Write("experiment.yaml", TemplateExperiment(""));
  ASSERT_EQ(PlanOf(experiment, {"--poses=12", "--sigma_mm=0.2"}).status, 0);
  const auto rows = Cells(Read("plan/plan.csv"));
  ASSERT_EQ(rows.size(), 1u + 12 * 3);
  for (const char* column : {"sigma_x_mm", "sigma_y_mm", "sigma_z_mm"}) {
    for (size_t r = 1; r < rows.size(); ++r) EXPECT_EQ(rows[r][Column(rows, column)], "0.2") << column;
  }
  // The same from the rows themselves, which are candidates with that noise.
  const double promised = ReadJson("plan/plan.json").at("predicted").at("position_rms_mm");
  const std::string own = Write("own.csv", Read("plan/plan.csv"));
  ASSERT_EQ(PlanOf(experiment, {"--poses=12", "--candidates=" + own, "--tests=" + own}).status, 0);
  const double stated = ReadJson("plan/plan.json").at("predicted").at("position_rms_mm");
  ASSERT_EQ(PlanOf(experiment, {"--poses=12", "--candidates=" + own, "--tests=" + own, "--sigma_mm=0.2"}).status, 0);
  EXPECT_NEAR(stated, ReadJson("plan/plan.json").at("predicted").at("position_rms_mm"), 1e-9);
  EXPECT_GT(promised, 0.0);
}

// Test poses are not measured, and candidates are measured as the rows are: neither needs sigma columns next to rows
// that have some. What is promised is what is promised where they state them.
TEST_F(PlanCommandTest, TestsAndCandidatesNeedNoSigma) {
  const std::string columns = ",sigma_x_mm,sigma_y_mm,sigma_z_mm", head = kTemplateHead;
  Write("rows.csv", head + columns + "\n" + Template(",0.02,0.03,0.3"));
  const std::string experiment = Write("experiment.yaml", TemplateExperiment(""));
  std::string bare = head + "\n", stated = head + columns + "\n", absurd = head + columns + "\n";
  for (int c = 0; c < 40; ++c) {
    for (const char* marker : {"M3", "M1", "M2"}) {
      std::string row = "c" + std::to_string(c) + "," + marker + ",S1";
      const double turn[6] = {70, 60, 100, 150, 100, 150}, middle[6] = {0, -70, 20, 0, 0, 0};
      for (int j = 0; j < 6; ++j) row += "," + std::to_string(middle[j] + turn[j] * std::sin(1.7 * c * (j + 1) + j));
      bare += row + "\n";
      stated += row + ",0.02,0.03,0.3\n";
      absurd += row + ",3,3,3\n";
    }
  }
  const std::string without = Write("bare.csv", bare), with = Write("stated.csv", stated);
  const auto promised = [&](const std::string& candidates, const std::string& tests) {
    const Outcome outcome =
        PlanOf(experiment, {"--poses=15", "--nomove", "--candidates=" + candidates, "--tests=" + tests});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return ReadJson("plan/plan.json").at("predicted").at("position_rms_mm").get<double>();
  };
  const double expected = promised(with, Write("absurd.csv", absurd));
  EXPECT_NEAR(promised(with, without), expected, 1e-9);
  EXPECT_NEAR(promised(without, without), expected, 1e-9);
  EXPECT_NE(Read("plan/plan.json").find("120 rows of the candidates state no standard deviation"), std::string::npos);
  const auto rows = Cells(Read("plan/plan.csv"));  // measured with what it counts
  for (size_t r = 1; r < rows.size(); ++r) EXPECT_EQ(rows[r][Column(rows, "sigma_z_mm")], "0.3");
  // The other way round: tests that state some do not make those of the rows missing.
  Write("rows.csv", head + "\n" + Template(""));
  const std::string of_all = Write("of_all.yaml", TemplateExperiment(""));
  const std::vector<std::string> request = {"--poses=15", "--candidates=" + without, "--tests=" + with};
  EXPECT_NE(PlanOf(of_all, request).err.find("nothing states their noise"), std::string::npos);
}

// As where they are validation rows of the experiment: registered there.
TEST_F(PlanCommandTest, AFileOfTestsMaySeeStationsAndMarkersOfItsOwn) {
  const std::string head = kTemplateHead;
  std::string tests, validation;
  for (int c = 0; c < 9; ++c) {
    for (const char* seen : {"TCP,S1", "M1,S2", "M2,S2", "M3,S2"}) {
      std::string row = "t" + std::to_string(c) + "," + seen;
      for (int j = 0; j < 6; ++j) row += "," + std::to_string(10 * std::sin(2.3 * c * (j + 1)) - (j == 1 ? 80 : 0));
      tests += row + "\n";
      validation += row + ",validation\n";
    }
  }
  const std::string where = "noise: {sigma_mm: 0.05}\n", tcp = ", TCP: {xyz_mm: [400, 0, 0]}}\n";
  std::string text = TemplateExperiment(where);
  text.replace(text.find("}\nnoise"), 2, tcp);
  const auto promised = [&](const std::string& experiment, const std::vector<std::string>& more) {
    const Outcome outcome = PlanOf(experiment, more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return ReadJson("plan/plan.json").at("predicted").at("position_rms_mm").get<double>();
  };
  Write("rows.csv", head + ",set\n" + Template(",calibration") + validation);
  const double expected = promised(Write("whole.yaml", text), {"--poses=15", "--nomove"});
  Write("rows.csv", head + "\n" + Template(""));
  const std::string apart = Write("apart.yaml", text), file = Write("tests.csv", head + "\n" + tests);
  EXPECT_NEAR(promised(apart, {"--poses=15", "--nomove", "--tests=" + file}), expected, 1e-6 * expected);
  EXPECT_NE(Read("plan/plan.json").find("registered on the test poses"), std::string::npos);
  // A marker that nothing places, and names that no candidate may have.
  const std::string bare = Write("bare.yaml", TemplateExperiment(where));
  EXPECT_NE(PlanOf(bare, {"--poses=15", "--tests=" + file}).err.find("nothing says where marker 'TCP' is"),
            std::string::npos);
  const Outcome refused = PlanOf(bare, {"--poses=15", "--candidates=" + file});
  EXPECT_NE(refused.err.find("tests.csv:2: marker: the experiment has no marker 'TCP'"), std::string::npos)
      << refused.err;
}

// Nothing is measured yet: one configuration is enough, whatever will be held out of the readings.
TEST_F(PlanCommandTest, AStatedValidationDoesNotRefuseATemplate) {
  Write("rows.csv", std::string(kTemplateHead) + "\n" + Template(""));
  const auto promised = [&](const std::string& more) {
    const std::string text = TemplateExperiment("noise: {sigma_mm: 0.05}\n" + more);
    const Outcome outcome = PlanOf(Write("experiment.yaml", text), {"--poses=15", "--nomove"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const bool is_said = Read("plan/plan.json").find("the plan holds none out") != std::string::npos;
    EXPECT_EQ(is_said, !more.empty());
    return ReadJson("plan/plan.json").at("predicted").at("position_rms_mm").get<double>();
  };
  const double expected = promised("");
  EXPECT_EQ(promised("validation: {fraction: 0.3, seed: 1, by: config}\n"), expected);
  EXPECT_EQ(promised("validation: {column: set}\n"), expected);
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
