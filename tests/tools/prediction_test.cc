// What an estimate says of other rows: the same point whatever stands next to it in the file, and how well it is known.
#include <cmath>

#include "tests/tools/program.h"

namespace sagitta::test::prediction_test {
namespace {

using Rows = std::vector<std::vector<std::string>>;

class PredictionTest : public ProgramTest {
 protected:
  const std::string robot_ = Published("kr270/robot.yaml");
  const std::string data_ = Published("kr270/geometric.csv");

  Outcome Predict(const std::string& rows) const {
    return Run({"predict", Path("out/estimate.json"), rows, "--out=" + Path("predicted.csv")});
  }
  // pred_x, y, z of two files agree from row `first` of the one on.
  void ExpectSamePoints(const Rows& whole, const Rows& part, size_t first) const {
    ASSERT_EQ(part.size() - 1, whole.size() - first);
    for (size_t i = 1; i < part.size(); ++i) {
      for (const char* name : {"pred_x_mm", "pred_y_mm", "pred_z_mm"}) {
        EXPECT_NEAR(std::stod(part[i][Column(part, name)]), std::stod(whole[first + i - 1][Column(whole, name)]), 1e-9)
            << name << " of row " << i;
      }
    }
  }
  // The published rows over a warm-up of two hours.
  Rows WarmingUp() const {
    Rows rows = Cells(ReadAll(data_));
    const double last = static_cast<double>(rows.size()) - 1.0;
    for (size_t i = 0; i < rows.size(); ++i) {
      const double way = static_cast<double>(i) / last;
      rows[i].push_back(i == 0 ? "time_s" : std::to_string(1000.0 + 7200.0 * way));
      rows[i].push_back(i == 0 ? "temperature_degC" : std::to_string(20.0 + 8.0 * way * way));
    }
    return rows;
  }
  std::string RobotThatDriftsAndGrows() const {
    return Write("drifting.yaml", ReadAll(robot_) + "effects:\n  - {effect: thermal_growth, growth_ppm_per_K: 0}\n" +
                                      "  - {effect: station_drift, station: S2, x_um_per_h: 0}\n");
  }
};

TEST_F(PredictionTest, TimeAndTemperatureCountFromTheRowsOfTheEstimate) {
  const Rows rows = WarmingUp();
  const std::string all = Write("all.csv", Csv(rows));
  ASSERT_EQ(Run({"calibrate", RobotThatDriftsAndGrows(), all, "--sigma_mm=0.1", "--out=" + Path("out")}).status, 0);
  ASSERT_EQ(Predict(all).status, 0);
  const Rows whole = Cells(Read("predicted.csv"));
  Rows part = {rows[0]};
  const size_t first = rows.size() - 12;
  part.insert(part.end(), rows.begin() + static_cast<long>(first), rows.end());
  const Outcome outcome = Predict(Write("part.csv", Csv(part)));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  ExpectSamePoints(whole, Cells(Read("predicted.csv")), first);
}

// Rows alone say nothing of what was driven to before them.
TEST_F(PredictionTest, AnEffectWithAMemoryIsWarnedOf) {
  const std::string effects = "effects:\n  - {effect: hysteresis, joint: A2, width_deg: 3, amplitude_urad: 200}\n";
  const std::string arm = Write("arm.yaml", ReadAll(robot_) + effects);
  for (const auto& [robot, warned] : {std::pair(arm, true), std::pair(robot_, false)}) {
    ASSERT_EQ(Run({"calibrate", robot, data_, "--sigma_mm=0.1", "--out=" + Path("out")}).status, 0);
    const Outcome outcome = Predict(data_);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const std::string words = "effect/hysteresis[width_deg=3]/A2 depends on what was done before each row";
    EXPECT_EQ(outcome.out.find(words) != std::string::npos, warned) << outcome.out;
  }
}

TEST_F(PredictionTest, TheColumnsThatAnEffectNeedsAreAskedFor) {
  const std::string all = Write("all.csv", Csv(WarmingUp()));
  ASSERT_EQ(Run({"calibrate", RobotThatDriftsAndGrows(), all, "--sigma_mm=0.1", "--out=" + Path("out")}).status, 0);
  const Outcome outcome = Predict(data_);
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("temperature_degC"), std::string::npos) << outcome.err;
  EXPECT_FALSE(Exists("predicted.csv"));
}

// The calibrated joint 2 carries its error, and the spring on it keeps its own zero.
TEST_F(PredictionTest, ASpringOnAnOffsetJointIsTheOneOfTheFit) {
  const std::string loaded = Published("kr270/loaded.csv");
  ASSERT_EQ(Run({"calibrate", Published("kr270/all_stages.yaml"), "--out=" + Path("out")}).status, 0);
  EXPECT_NE(Read("out/robot.calibrated.yaml").find("zero_deg"), std::string::npos);
  ASSERT_EQ(Predict(loaded).status, 0);
  ExpectSamePoints(Cells(Read("out/residuals.csv")), Cells(Read("predicted.csv")), 1);
}

// Nine equations for nine unknowns: a perfect fit shows no noise, and nothing is known to 0.0000 mm.
TEST_F(PredictionTest, WithoutRedundancyNoDeviationIsClaimed) {
  const Rows all = Cells(ReadAll(data_));
  Rows few = {all[0]};
  for (size_t i = 1; i < all.size() && few.size() < 4; ++i) {
    if (all[i][Column(all, "station")] == "S1" && all[i][Column(all, "marker")] == "P1") few.push_back(all[i]);
  }
  Write("few.csv", Csv(few));
  const std::string experiment =
      Write("few.yaml", "schema: sagitta/experiment/1\nrobot: " + robot_ +
                            "\nmeasurements: [few.csv]\nvalidation: none\nestimate: {geometry: none}\n");
  ASSERT_EQ(Run({"calibrate", experiment, "--out=" + Path("out")}).status, 0);
  const auto read = ReadJson("out/estimate.json");
  for (const auto& parameter : read["parameters"]) {
    EXPECT_TRUE(parameter["sigma"].is_null()) << parameter["name"];
  }
  const Outcome outcome = Predict(Path("few.csv"));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("not known"), std::string::npos) << outcome.out;
  const Rows predicted = Cells(Read("predicted.csv"));
  EXPECT_EQ(predicted[1][Column(predicted, "psig_x_mm")], "");
}

// What FORMATS lists of sigma is enough.
TEST_F(PredictionTest, AnEstimateNeedNotSayMoreThanTheFormat) {
  ASSERT_EQ(Run({"calibrate", Published("kr270/experiment.yaml"), "--out=" + Path("out")}).status, 0);
  auto estimate = nlohmann::ordered_json::parse(Read("out/estimate.json"));
  estimate["sigma"] = {{"a_posteriori", 1.0}, {"scaled", false}};
  Write("out/estimate.json", estimate.dump());
  ASSERT_EQ(Predict(data_).status, 0);
  const Rows predicted = Cells(Read("predicted.csv"));
  EXPECT_GT(std::stod(predicted[1][Column(predicted, "psig_x_mm")]), 0.01);
}

// The hat matrix has the rank of the model as its trace, joints that stop elsewhere each time included.
TEST_F(PredictionTest, LeveragesSumToTheRank) {
  const std::string experiment =
      Write("e.yaml", "schema: sagitta/experiment/1\nrobot: " + robot_ + "\nmeasurements: [" + data_ +
                          "]\nvalidation: none\nnoise: {sigma_mm: 0.01}\nrepeatability_urad: 30\n");
  ASSERT_EQ(Run({"calibrate", experiment, "--out=" + Path("out")}).status, 0);
  const Rows rows = Cells(Read("out/residuals.csv"));
  double sum = 0.0;
  for (size_t i = 1; i < rows.size(); ++i) {
    const double leverage = std::stod(rows[i][Column(rows, "leverage")]);
    EXPECT_LE(leverage, 1.0);
    sum += 3.0 * leverage;
  }
  EXPECT_NEAR(sum, 39.0, 1e-6);
}

}  // namespace
}  // namespace sagitta::test::prediction_test
