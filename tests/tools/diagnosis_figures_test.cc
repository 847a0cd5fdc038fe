// Figures of diagnosis.json and estimate.json recomputed from their own others and from residuals.csv.
#include <cmath>

#include "estimator/statistics/distributions.h"
#include "tests/support/random_numbers.h"
#include "tests/tools/program.h"

namespace sagitta::test::diagnosis_figures_test {
namespace {

using Json = nlohmann::json;

class DiagnosisFiguresTest : public ProgramTest {
 protected:
  // 45 configurations of the published arm, three markers; every other one loaded with 2 kN where asked for.
  void Simulate(const std::string& true_keys, bool loaded) const {
    RandomNumbers random(4);
    std::string csv = "config,marker,load,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,fx_N,fy_N,fz_N,set\n";
    const double low[6] = {-150, -140, -100, -170, -110, -170}, high[6] = {150, 0, 140, 170, 110, 170};
    for (int c = 0; c < 45; ++c) {
      std::string q;
      for (int j = 0; j < 6; ++j) q += "," + std::to_string(random.Uniform(low[j], high[j]));
      for (const std::string load : {"none", "V"}) {
        if (load == "V" && !loaded) continue;
        for (const char* marker : {"P1", "P2", "P3"}) {
          csv += "C" + std::to_string(c) + "," + marker + "," + load + q + (load == "V" ? ",0,0,-2000," : ",0,0,0,") +
                 (c % 3 == 0 ? "validation\n" : "calibration\n");
        }
      }
    }
    Write("rows.csv", csv);
    const std::string robot = ReadAll(Published("kr270/robot.yaml"));
    Write("robot.yaml", robot + believed_);
    Write("true_robot.yaml", robot + true_keys);
    const std::string truth = Experiment("truth.yaml", "true_robot.yaml", "rows.csv",
                                         "stations: {S1: {xyz_mm: [100, 200, 300], rotvec_mrad: [20, 30, 500]}}\n"
                                         "markers: {P1: {xyz_mm: [279, -16, -92]}, P2: {xyz_mm: [10, 200, 100]}, "
                                         "P3: {xyz_mm: [100, -100, 200]}}\n");
    const Outcome outcome = Run({"simulate", truth, "--truth=" + truth, "--out=" + Path("data.csv"), "--seed=2"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  std::string Experiment(const std::string& name, const std::string& robot, const std::string& data,
                         const std::string& more) const {
    return Write(name, "schema: sagitta/experiment/1\nrobot: " + robot + "\nmeasurements: [" + data +
                           "]\nload_point_mm: [280, 60, -150]\nnoise: {sigma_mm: 0.03}\nvalidation: {column: set}\n" +
                           more);
  }
  Json Diagnose(const std::string& more) const {
    const Outcome outcome =
        Run({"diagnose", Experiment("experiment.yaml", "robot.yaml", "data.csv", more), "--out=" + Path("out")});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return ReadJson("out/diagnosis.json");
  }
  std::string believed_;
};

TEST_F(DiagnosisFiguresTest, GapProbabilitiesAndIntervals) {
  Simulate("effects: [{effect: joint_harmonic, joint: A3, order: 1, cos_urad: 260, sin_urad: -150}]\n", false);
  const Json json = Diagnose("");
  ASSERT_EQ(json["steps"].size(), 1u) << json["words"];
  const Json& step = json["steps"][0];
  ASSERT_EQ(step["effect"], "joint_harmonic");
  const double truth[2] = {260, -150};
  for (int p = 0; p < 2; ++p) {
    const Json& row = step["parameters"][p];
    const double value = row["value"], sigma = row["sigma"];
    EXPECT_NEAR(value, truth[p], 5 * sigma);
    EXPECT_NEAR((row["ci95"][1].get<double>() - value) / sigma, 1.96, 0.1);  // Student's at some hundred degrees
    EXPECT_NEAR((value - row["ci95"][0].get<double>()) / sigma, 1.96, 0.1);
  }
  // gap^2 = hold-out^2 - floor^2, of both models; what is closed is a share of squares.
  const double floor = json["final"]["noise_floor_mm"];
  const auto squared_gap = [floor](double holdout) { return std::max(0.0, holdout * holdout - floor * floor); };
  const double before = squared_gap(json["baseline"]["holdout_rms_mm"]);
  const double after = squared_gap(json["final"]["holdout_rms_mm"]);
  EXPECT_NEAR(json["final"]["gap_before_mm"].get<double>(), std::sqrt(before), 1e-9);
  EXPECT_NEAR(json["final"]["gap_after_mm"].get<double>(), std::sqrt(after), 1e-9);
  EXPECT_NEAR(json["final"]["gap_closed"].get<double>(), 1.0 - after / before, 1e-9);
  EXPECT_GT(before, 4 * after);
  EXPECT_GT(before, 1e-4);
  // Hold-out and floor are those of residuals.csv.
  const auto rows = Cells(Read("out/residuals.csv"));
  double squares = 0.0;
  int held_out = 0;
  for (size_t i = 1; i < rows.size(); ++i) {
    if (rows[i][Column(rows, "set")] != "validation") continue;
    ++held_out;
    for (const std::string axis : {"x", "y", "z"}) {
      squares += std::pow(std::stod(rows[i][Column(rows, "res_" + axis + "_mm")]), 2);
    }
  }
  EXPECT_EQ(held_out, 45);
  EXPECT_NEAR(json["final"]["holdout_rms_mm"].get<double>(), std::sqrt(squares / (3.0 * held_out)), 1e-9);
  // p-values count how many were looked at, with all their settings.
  int looked_at = 0;
  for (const Json& candidate : json["candidates"]) {
    const std::string effect = candidate["effect"];
    if (effect != "encoder_gain" && effect != "joint_coupling" && effect != "frozen_geometry")
      continue;  // one parameter
    const double p = candidate["p_value"], score = candidate["score"];
    const double scatter = json["baseline"]["reduced_chi2"];
    const double alone = scatter <= 1.0 ? ChiSquareSurvival(score, 1.0) : FSurvival(score / scatter, 1.0, 1e9);
    if (alone < 1e-5)
      continue;  // beyond, some two hundred degrees of freedom differ from a billion by more than a half
    const double corrected = std::min(1.0, json["screened"].get<double>() * alone);
    EXPECT_GE(p, 0.9 * corrected) << candidate;
    EXPECT_LE(p, 2.0 * corrected) << candidate;
    ++looked_at;
  }
  EXPECT_GT(looked_at, 0) << json["candidates"];
}

// What is found in addition to a believed compliance is added to it in its home.
TEST_F(DiagnosisFiguresTest, AFoundComplianceIsAddedToTheBelievedOne) {
  believed_ = "compliance: {A2: {k_urad_per_Nm: 0.3}, A3: {k_urad_per_Nm: 0.2}}\n";
  Simulate("compliance: {A2: {k_urad_per_Nm: 0.3}, A3: {k_urad_per_Nm: 0.5}}\n", true);
  const Json json = Diagnose("estimate: {compliance: none}\n");
  ASSERT_EQ(json["steps"].size(), 1u) << json["words"];
  ASSERT_EQ(json["steps"][0]["effect"], "joint_compliance") << json["words"];
  ASSERT_EQ(json["steps"][0]["target"], "A3");
  const Json& found = json["steps"][0]["parameters"][0];
  EXPECT_NEAR(found["value"].get<double>(), 0.3, 5 * found["sigma"].get<double>());
  const std::string robot = Read("out/robot.extended.yaml");
  const size_t at = robot.find("A3: {k_urad_per_Nm: ");
  ASSERT_NE(at, std::string::npos) << robot;
  const double k = std::stod(robot.substr(at + std::string("A3: {k_urad_per_Nm: ").size()));
  EXPECT_NEAR(k, 0.2 + found["value"].get<double>(), 1e-6);
}

// Every interval is as wide as Student's quantile says of its standard deviation, in the same unit.
TEST_F(DiagnosisFiguresTest, IntervalsAreInTheUnitOfTheirSigma) {
  Simulate("", false);
  const std::string experiment = Experiment("experiment.yaml", "robot.yaml", "data.csv", "");
  ASSERT_EQ(Run({"calibrate", experiment, "--out=" + Path("fit")}).status, 0);
  const Json json = ReadJson("fit/estimate.json");
  int checked = 0;
  for (const Json& row : json["parameters"]) {
    if (row["sigma"].is_null()) continue;
    const double value = row["value"], sigma = row["sigma"], own = row["sigma_noise_only"];
    EXPECT_NEAR((row["ci95"][1].get<double>() - value) / sigma, 1.96, 0.1) << row["name"];
    EXPECT_NEAR((value - row["ci95"][0].get<double>()) / sigma, 1.96, 0.1) << row["name"];
    EXPECT_NEAR((row["ci95_noise_only"][1].get<double>() - value) / own, 1.96, 0.1) << row["name"];
    EXPECT_NEAR((value - row["ci95_noise_only"][0].get<double>()) / own, 1.96, 0.1) << row["name"];
    ++checked;
  }
  EXPECT_GT(checked, 25);
}

}  // namespace
}  // namespace sagitta::test::diagnosis_figures_test
