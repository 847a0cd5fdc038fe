// Intervals as a user gets them: covariance in an experiment, predict, coverage.
#include <cmath>

#include "tests/tools/program.h"

namespace sagitta::test::intervals_command_test {
namespace {

using nlohmann::json;

class IntervalsCommandTest : public ProgramTest {
 protected:
  std::string ExperimentWith(const std::string& name, const std::string& extra) const {
    return Write(name, "schema: sagitta/experiment/1\nrobot: " + Published("kr270/robot.yaml") + "\nmeasurements: [" +
                           Published("kr270/geometric.csv") + "]\nnoise: {sigma_mm: 0.1}\n" + extra);
  }
  // Configurations spread over the joints' ranges (golden ratios), three markers, without points.
  static std::string Design(int configurations) {
    const double low[] = {-130, -130, -80, -170, -85, -170}, wide[] = {260, 120, 180, 340, 170, 340};
    const double step[] = {0.8567, 0.7339, 0.6287, 0.5386, 0.4614, 0.3952};
    std::string text = "config,marker,station,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n";
    for (int c = 0; c < configurations; ++c) {
      std::string joints;
      for (int j = 0; j < 6; ++j) {
        const double at = (c + 1) * step[j];
        joints += "," + std::to_string(low[j] + wide[j] * (at - std::floor(at)));
      }
      for (const char* marker : {"P1", "P2", "P3"}) {
        text += "D" + std::to_string(c) + "," + marker + ",S1" + joints + "\n";
      }
    }
    return text;
  }
  json Calibrate(const std::string& name, const std::string& extra) const {
    const Outcome outcome = Run({"calibrate", ExperimentWith(name + ".yaml", extra), "--out=" + Path(name)});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return ReadJson(name + "/estimate.json");
  }
};

TEST_F(IntervalsCommandTest, EveryCovarianceSaysWhichItIs) {
  const json model = Calibrate("model", "");
  for (const char* covariance : {"model", "sandwich", "bootstrap", "profile"}) {
    const std::string extra = std::string("covariance: ") + covariance + "\nbootstrap: {replicates: 199, seed: 3}\n";
    const json estimate = Calibrate(covariance, extra);
    EXPECT_EQ(estimate["intervals"]["method"], covariance);
    ASSERT_EQ(estimate["parameters"].size(), model["parameters"].size());
    int compared = 0;
    for (size_t i = 0; i < model["parameters"].size(); ++i) {
      const json& a = model["parameters"][i];
      const json& b = estimate["parameters"][i];
      EXPECT_NEAR(a["value"].get<double>(), b["value"].get<double>(), 1e-9);
      if (a["sigma"].is_null()) continue;
      EXPECT_EQ(b["interval"], covariance);
      EXPECT_LT(b["ci95"][0].get<double>(), b["value"].get<double>());
      EXPECT_GT(b["ci95"][1].get<double>(), b["value"].get<double>());
      ++compared;
    }
    EXPECT_EQ(compared, 39);
  }
  EXPECT_EQ(ReadJson("bootstrap/estimate.json")["intervals"]["kind"], "parametric");
  EXPECT_EQ(ReadJson("bootstrap/estimate.json")["intervals"]["seed"], 3);
  EXPECT_EQ(ReadJson("sandwich/estimate.json")["intervals"]["clusters"], 18);
}

TEST_F(IntervalsCommandTest, BadBootstrapSettingsAreNamed) {
  for (const char* extra : {"bootstrap: {kind: jackknife}", "bootstrap: {replicates: 5}", "bootstrap: {draws: 5}"}) {
    const Outcome outcome = Run({"calibrate", ExperimentWith("bad.yaml", extra + std::string("\n"))});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("bootstrap"), std::string::npos) << outcome.err;
  }
  const Outcome other =
      Run({"calibrate", ExperimentWith("profile.yaml", "covariance: profile\n"), "--method=two-step"});
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.err.find("covariance"), std::string::npos) << other.err;
}

TEST_F(IntervalsCommandTest, ThePredictedEllipsoidIsTheCovariance) {
  Calibrate("model", "repeatability_urad: 8\n");
  const Outcome outcome =
      Run({"predict", Path("model/estimate.json"), Published("kr270/geometric.csv"), "--out=" + Path("p.csv")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto rows = Cells(Read("p.csv"));
  ASSERT_GT(rows.size(), 10u);
  const auto number = [&](size_t r, const std::string& name) { return std::stod(rows[r][Column(rows, name)]); };
  for (size_t r = 1; r < rows.size(); ++r) {
    double trace = 0.0;
    for (const char* axis : {"x", "y", "z"}) trace += std::pow(number(r, std::string("psig_") + axis + "_mm"), 2);
    EXPECT_NEAR(number(r, "psig_distance_mm"), std::sqrt(trace), 1e-12);
    // sum over axes of lambda v v' gives the covariance back.
    double xx = 0.0, xy = 0.0;
    for (const char* axis : {"paxis1", "paxis2", "paxis3"}) {
      const double size = number(r, std::string(axis) + "_mm");
      const double x = number(r, std::string(axis) + "_x"), y = number(r, std::string(axis) + "_y");
      xx += size * size * x * x;
      xy += size * size * x * y;
    }
    EXPECT_NEAR(xx, std::pow(number(r, "psig_x_mm"), 2), 1e-9);
    EXPECT_NEAR(xy, number(r, "pcov_xy_mm2"), 1e-9);
    EXPECT_EQ(number(r, "pnoise_x_mm"), 0.1);
    // Six joints of 8 urad, arms of up to 4 m: some hundredths of a millimetre.
    EXPECT_GT(number(r, "parm_x_mm"), 0.001);
    EXPECT_LT(number(r, "parm_x_mm"), 0.1);
    EXPECT_EQ(number(r, "pheld_x_mm"), 0.0);
  }
}

// 400 urad of a once-per-turn error in A3: parts of the data contradict each other, and the report, the estimate, and
// whoever predicts from it say so. Simulated with the program, at joint values that are off.
TEST_F(IntervalsCommandTest, WhatTheModelLacksIsReportedWithTheIntervals) {
  const std::string rows = Write("design.csv", Design(60));
  const auto commanded = Cells(Read("design.csv"));
  auto actual = commanded;
  const int q3 = Column(actual, "q3_deg");
  for (size_t r = 1; r < actual.size(); ++r) {
    const double q = std::stod(actual[r][q3]);
    actual[r][q3] = std::to_string(q + 0.0229 * std::cos(2.0 * q * 0.017453292519943295));
  }
  Write("actual.csv", Csv(actual));
  Calibrate("truth", "");
  const std::string robot = Published("kr270/robot.yaml"), truth = "--truth=" + Path("truth/estimate.json");
  for (const bool lacks : {false, true}) {
    const std::string how = lacks ? Path("actual.csv") : rows;
    ASSERT_EQ(Run({"simulate", robot, how, truth, "--sigma_mm=0.05", "--out=" + Path("m.csv")}).status, 0);
    auto measured = Cells(Read("m.csv"));
    for (size_t r = 1; r < measured.size(); ++r) measured[r][Column(measured, "q3_deg")] = commanded[r][q3];
    Write("m.csv", Csv(measured));
    const Outcome outcome = Run({"calibrate", robot, Path("m.csv"), "--sigma_mm=0.05", "--out=" + Path("out")});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json agreement = ReadJson("out/estimate.json")["agreement"];
    EXPECT_EQ(agreement["disagrees"], lacks);
    const std::string words = lacks ? "contradict each other" : "No part of the data contradicts another";
    EXPECT_NE(outcome.out.find(words), std::string::npos) << outcome.out;
    EXPECT_NE(Read("out/report.html").find(words), std::string::npos);
    ASSERT_EQ(agreement["kinds"].size(), 3u);
    EXPECT_EQ(agreement["kinds"][0]["by"], "random");
    EXPECT_EQ(agreement["kinds"][1]["by"], "region");
    EXPECT_EQ(agreement["kinds"][2]["by"], "marker");
    EXPECT_EQ(agreement["splits"].size(), 12u);  // six joints, x, y, z; three markers
    const double inflation = agreement["inflation"].get<double>();
    EXPECT_EQ(inflation > 1.2, lacks) << inflation;
    EXPECT_EQ(inflation == 1.0, !lacks) << inflation;
    const Outcome predicted = Run({"predict", Path("out/estimate.json"), rows, "--out=" + Path("p.csv")});
    EXPECT_EQ(predicted.out.find("carry the model error") != std::string::npos, lacks) << predicted.out;
  }
}

TEST_F(IntervalsCommandTest, CoverageIsTheSameHoweverItRuns) {
  const std::string experiment = ExperimentWith("e.yaml", "");
  const auto run = [&](const std::string& out, const std::string& trials, const std::string& threads) {
    return Run(
        {"coverage", experiment, "--trials=" + trials, "--threads=" + threads, "--out=" + Path(out), "--seed=5"});
  };
  ASSERT_EQ(run("one", "24", "1").status, 0);
  ASSERT_EQ(run("two", "24", "2").status, 0);
  // Interrupted after 10 trials, in the middle of writing the 11th.
  ASSERT_EQ(run("broken", "10", "2").status, 0);
  Write("broken/coverage.state.jsonl", Read("broken/coverage.state.jsonl") + "{\"trial\":10,\"status\":\"conv");
  ASSERT_EQ(run("broken", "24", "1").status, 0);
  json one = ReadJson("one/coverage.json"), two = ReadJson("two/coverage.json"),
       broken = ReadJson("broken/coverage.json");
  for (json* result : {&one, &two, &broken}) result->erase("command");
  EXPECT_EQ(one, two);
  EXPECT_EQ(one, broken);
  EXPECT_EQ(one["trials"], 24);
  EXPECT_EQ(one["seed"], 5);
  ASSERT_EQ(one["parameters"].size(), 39u);
  double coverage = 0.0, efficiency = 0.0;
  for (const json& row : one["parameters"]) {
    coverage += row["coverage"].get<double>() / 39;
    efficiency += row["efficiency_same_draws"].get<double>() / 39;
    EXPECT_LE(row["coverage_ci95"][0].get<double>(), row["coverage"].get<double>());
    EXPECT_GE(row["coverage_ci95"][1].get<double>(), row["coverage"].get<double>());
    // 24 draws: RMSE over the bound within 1 +- 4.5 / sqrt(48).
    EXPECT_NEAR(row["efficiency"].get<double>(), 1.0, 4.5 / std::sqrt(48.0)) << row["name"];
  }
  EXPECT_NEAR(coverage, 0.95, 0.05);  // 24 x 39, correlated within a draw
  EXPECT_NEAR(efficiency, 1.0, 0.01);
}

TEST_F(IntervalsCommandTest, CoverageRefusesTheStateOfAnotherRun) {
  const std::string experiment = ExperimentWith("e.yaml", "");
  ASSERT_EQ(Run({"coverage", experiment, "--trials=2", "--out=" + Path("c"), "--seed=5"}).status, 0);
  const std::string before = Read("c/coverage.json");
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& why) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
    EXPECT_EQ(Read("c/coverage.json"), before);
  };
  refused({"coverage", experiment, "--trials=2", "--out=" + Path("c"), "--seed=6"}, "seed 5 there, 6 here");
  refused({"coverage", experiment, "--trials=2", "--out=" + Path("c"), "--seed=5", "--sigma_mm=0.2"}, "flags");
  refused(
      {"coverage", ExperimentWith("f.yaml", "covariance: sandwich\n"), "--trials=2", "--out=" + Path("c"), "--seed=5"},
      "covariance");
  refused({"coverage", experiment, "--trials=0", "--out=" + Path("c")}, "--trials");
  refused({"coverage", experiment, "--trials=2"}, "--out");
}

}  // namespace
}  // namespace sagitta::test::intervals_command_test
