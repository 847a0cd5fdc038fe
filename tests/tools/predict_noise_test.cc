// What predict and validate say of one measurement, under every noise model an experiment can state.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tests/tools/program.h"

namespace sagitta::test::predict_noise_test {
namespace {

using nlohmann::json;

class PredictNoiseTest : public ProgramTest {
 protected:
  // Four repeats of the published configurations, simulated with 30 um and joints that deviate by 20 urad.
  void SetUp() override {
    ProgramTest::SetUp();
    const auto rows = Cells(ReadAll(Published("kr270/geometric.csv")));
    std::vector<std::vector<std::string>> repeated = {rows[0]};
    repeated[0].push_back("repeat");
    for (size_t r = 1; r < rows.size(); ++r) {
      for (int k = 1; k <= 4; ++k) {
        repeated.push_back(rows[r]);
        repeated.back().push_back(std::to_string(k));
      }
    }
    Write("design.csv", Csv(repeated));
    const std::string plain = Experiment("plain", Published("kr270/geometric.csv"), "noise: {sigma_mm: 0.1}\n");
    ASSERT_EQ(Run({"calibrate", plain, "--out=" + Path("truth")}).status, 0);
  }
  std::string Experiment(const std::string& name, const std::string& data, const std::string& keys) const {
    return Write(name + ".yaml", "schema: sagitta/experiment/1\nrobot: " + Published("kr270/robot.yaml") +
                                     "\nmeasurements: [" + data + "]\nvalidation: none\n" + keys);
  }
  // Measures the design under `simulated`, calibrates under `keys`, predicts the rows; returns the table.
  std::vector<std::vector<std::string>> Predict(const std::string& simulated, const std::string& keys) {
    const std::string how = Experiment("how", Path("design.csv"), simulated);
    EXPECT_EQ(Run({"simulate", how, "--truth=" + Path("truth/estimate.json"), "--out=" + Path("m.csv")}).status, 0);
    const Outcome outcome = Run({"calibrate", Experiment("e", Path("m.csv"), keys), "--out=" + Path("out")});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(Run({"predict", Path("out/estimate.json"), Path("m.csv"), "--out=" + Path("p.csv")}).status, 0);
    EXPECT_EQ(Run({"validate", Path("out/estimate.json"), Path("m.csv"), "--out=" + Path("v")}).status, 0);
    return Cells(Read("p.csv"));
  }
  double PredictedOverObserved() const {
    const json validation = ReadJson("v/validation.json")["validation"];
    if (validation["predicted_rms_mm"].is_null()) return 0.0;
    return validation["predicted_rms_mm"].get<double>() / validation["rms_mm"].get<double>();
  }
};

const char* const kPlain = "noise: {sigma_mm: 0.03}\nrepeatability_urad: 20\n";

TEST_F(PredictNoiseTest, WhereNoNoiseIsKnownNothingIsExpectedOfTheErrors) {
  Predict(kPlain, kPlain);
  EXPECT_TRUE(ReadJson("v/validation.json")["validation"]["prediction_p_value"].is_number());
  json estimate = ReadJson("out/estimate.json");
  estimate["prediction_noise"]["sigma_mm"] = nullptr;
  estimate["prediction_noise"].erase("sigma_axis_mm");
  const std::string unknown = Write("unknown.json", estimate.dump());
  ASSERT_EQ(Run({"validate", unknown, Path("m.csv"), "--out=" + Path("v")}).status, 0);
  const json validation = ReadJson("v/validation.json")["validation"];
  EXPECT_TRUE(validation["rms_mm"].is_number());
  for (const char* key : {"predicted_rms_mm", "prediction_p_value", "excess"}) {
    EXPECT_TRUE(validation[key].is_null()) << key;
  }
}

TEST_F(PredictNoiseTest, EveryNoiseModelSaysWhatOneMeasurementShows) {
  for (const char* keys :
       {"noise: {sigma_mm: 0.03}\nrepeatability_urad: 20\n", "noise: {from: repeats}\n",
        "noise: {from: repeats}\nrepeatability_urad: 20\n", "noise: {from: variance-components}\n",
        "noise: {sigma_mm: 0.03}\nrepeatability_urad: estimate\n", "noise: {from: residuals, group: axis}\n",
        "weights: equal\n", "loss: huber\n", "noise: {sigma_mm: 0.03}\nloss: cauchy\nrepeatability_urad: 20\n",
        "noise: {sigma_mm: 0.03}\nweights: eq14\n"}) {
    const auto rows = Predict(kPlain, keys);
    ASSERT_EQ(rows.size(), 217u);
    // 30 um, or what the robot adds to it where nothing separates the two.
    for (const char* axis : {"pnoise_x_mm", "pnoise_y_mm", "pnoise_z_mm"}) {
      const std::string cell = rows[1][Column(rows, axis)];
      ASSERT_FALSE(cell.empty()) << keys;
      EXPECT_GT(std::stod(cell), 0.024) << keys;
      EXPECT_LT(std::stod(cell), 0.07) << keys;
    }
    // The rows were used in the fit: a little less is seen than predicted, not more.
    EXPECT_GT(PredictedOverObserved(), 0.9) << keys;
    EXPECT_LT(PredictedOverObserved(), 1.6) << keys;
  }
}

TEST_F(PredictNoiseTest, TheFactorOfVarianceComponentsIsInIt) {
  const auto rows = Predict(kPlain, "noise: {sigma_mm: 0.03}\nrepeatability_urad: 20\n");
  // Stated at two thirds: REML on sigma columns finds the factor.
  auto stated = Cells(Read("m.csv"));
  for (const char* name : {"sigma_x_mm", "sigma_y_mm", "sigma_z_mm"}) stated[0].push_back(name);
  for (size_t r = 1; r < stated.size(); ++r) {
    for (int k = 0; k < 3; ++k) stated[r].push_back("0.02");
  }
  Write("stated.csv", Csv(stated));
  const std::string experiment = Experiment("s", Path("stated.csv"), "noise: {from: variance-components}\n");
  ASSERT_EQ(Run({"calibrate", experiment, "--out=" + Path("s")}).status, 0);
  ASSERT_EQ(Run({"predict", Path("s/estimate.json"), Path("stated.csv"), "--out=" + Path("s.csv")}).status, 0);
  const auto predicted = Cells(Read("s.csv"));
  // 486 degrees of freedom of the repeats: 3.2 %.
  EXPECT_NEAR(std::stod(predicted[1][Column(predicted, "pnoise_x_mm")]), 0.03, 4 * 0.032 * 0.03);
}

TEST_F(PredictNoiseTest, AnInstrumentsCovarianceIsThatAtThePredictedPoint) {
  const std::string instrument =
      "noise: {instrument: {range_um: 10, range_um_per_m: 0.5, angle_um: 15, angle_um_per_m: 6}}\n"
      "stations: {S1: {instrument_mm: [4000, 300, 400]}, S2: {instrument_mm: [-500, -5000, 900]}}\n";
  Predict(instrument, instrument);
  // Rows without points: nothing but the prediction says where they are.
  auto without = Cells(Read("m.csv"));
  const int x = Column(without, "x_mm");
  for (auto& row : without) row.erase(row.begin() + x, row.begin() + x + 3);
  Write("poses.csv", Csv(without));
  ASSERT_EQ(Run({"predict", Path("out/estimate.json"), Path("poses.csv"), "--out=" + Path("q.csv")}).status, 0);
  const auto rows = Cells(Read("q.csv"));
  ASSERT_EQ(rows.size(), 217u);
  for (size_t r = 1; r < rows.size(); r += 25) {
    const auto number = [&](const std::string& name) { return std::stod(rows[r][Column(rows, name)]); };
    const bool first = rows[r][Column(rows, "station")] == "S1";
    const Eigen::Vector3d place = first ? Eigen::Vector3d(4, 0.3, 0.4) : Eigen::Vector3d(-0.5, -5, 0.9);
    const Eigen::Vector3d point(number("pred_x_mm"), number("pred_y_mm"), number("pred_z_mm"));
    const Eigen::Vector3d sight = 1e-3 * point - place;
    // In the frame of the sight: diag(range^2, across^2, across^2), um.
    const double along = 10 + 0.5 * sight.norm(), across = 15 + 6 * sight.norm();
    const Eigen::Matrix3d frame =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), sight).toRotationMatrix();
    const Eigen::Vector3d squares(along * along, across * across, across * across);
    const Eigen::Matrix3d covariance = 1e-6 * frame * squares.asDiagonal() * frame.transpose();  // mm^2
    EXPECT_NEAR(number("pnoise_x_mm"), std::sqrt(covariance(0, 0)), 1e-9);
    EXPECT_NEAR(number("pnoise_z_mm"), std::sqrt(covariance(2, 2)), 1e-9);
    EXPECT_NEAR(number("pnoise_xy_mm2"), covariance(0, 1), 1e-10);
    EXPECT_NEAR(number("pnoise_yz_mm2"), covariance(1, 2), 1e-10);
  }
  EXPECT_NEAR(PredictedOverObserved(), 1.0, 0.2);
}

}  // namespace
}  // namespace sagitta::test::predict_noise_test
