// Rows that are poses, through every command: simulated, calibrated, predicted, validated, inspected, diagnosed.
#include <cmath>

#include "tests/tools/program.h"

namespace sagitta::test::pose_command_test {
namespace {

using Rows = std::vector<std::vector<std::string>>;

class PoseCommandTest : public ProgramTest {
 protected:
  // The configurations of the published rows, one marker, without what was measured.
  std::string Configurations(const std::string& extra_header, const std::string& extra) const {
    const Rows rows = Cells(ReadAll(Published("kr270/geometric.csv")));
    std::string text = "config,marker";
    for (int j = 1; j <= 6; ++j) text += ",q" + std::to_string(j) + "_deg";
    text += extra_header + "\n";
    std::string last;
    for (size_t i = 1; i < rows.size(); ++i) {
      const std::string config = rows[i][Column(rows, "config")];
      if (config == last) continue;
      last = config;
      last = config;
      text += config + ",T";
      for (int j = 1; j <= 6; ++j) text += "," + rows[i][Column(rows, "q" + std::to_string(j) + "_deg")];
      text += extra + "\n";
    }
    return text;
  }
  std::string Scene(const std::string& measurements, const std::string& more) const {
    return "schema: sagitta/experiment/1\nrobot: " + Published("kr270/robot.yaml") + "\nmeasurements: " + measurements +
           "\n" + more;
  }
  const std::string truth_ =
      "stations: {S1: {xyz_mm: [100, 200, 300], rotvec_mrad: [20, -10, 400]}}\n"
      "markers: {T: {xyz_mm: [270, -50, 90], rotvec_mrad: [300, -1200, 500]}}\n";

  // simulated.csv: poses of the truth.
  void Simulate() {
    const std::string poses =
        Write("poses.csv", Configurations(",sigma_x_mm,sigma_y_mm,sigma_z_mm,sigma_rot_urad", ",0.02,0.02,0.02,60"));
    const Outcome outcome =
        Run({"simulate", Write("truth.yaml", Scene(poses, truth_)), "--out=" + Path("simulated.csv"), "--seed=3"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
};

TEST_F(PoseCommandTest, GoThroughEveryCommand) {
  Simulate();
  const Rows simulated = Cells(Read("simulated.csv"));
  EXPECT_GE(Column(simulated, "rx_mrad"), 0);
  const std::string calibration =
      Write("exp.yaml", Scene(Path("simulated.csv"), "validation: {fraction: 0.2, seed: 2}\n"));
  const Outcome calibrated = Run({"calibrate", calibration, "--out=" + Path("out")});
  ASSERT_EQ(calibrated.status, 0) << calibrated.err;
  const nlohmann::json estimate = ReadJson("out/estimate.json");
  // Of 60 urad over the residuals' degrees of freedom: within 0.03 to 0.09 mrad whatever the seed.
  EXPECT_NEAR(estimate["fit"]["rotation_rms_mrad"].get<double>(), 0.06, 0.03);
  EXPECT_TRUE(estimate["validation"].contains("rotation_rms_mrad"));
  const std::vector<double> expected = {300, -1200, 500};
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(estimate["markers"]["T"]["rotvec_mrad"][i].get<double>(), expected[i], 0.5);
  }
  double sigma = 0.0;
  for (const auto& row : estimate["parameters"]) {
    if (row["name"] != "marker/T/rx") continue;
    EXPECT_EQ(row["unit"], "mrad");
    sigma = row["sigma"].get<double>();
  }
  EXPECT_GT(sigma, 0.0);
  const Rows residuals = Cells(Read("out/residuals.csv"));
  EXPECT_EQ(residuals.size(), simulated.size()) << "a pose is one row";
  const double measured = std::stod(residuals[1][Column(residuals, "rx_mrad")]);
  const double predicted = std::stod(residuals[1][Column(residuals, "pred_rx_mrad")]);
  EXPECT_NEAR(measured, predicted, 2.0);
  EXPECT_LT(std::abs(std::stod(residuals[1][Column(residuals, "res_rx_mrad")])), 0.5);
  EXPECT_GE(Column(residuals, "whitened_rz"), 0);

  const std::string bare = Write("bare.csv", Configurations("", ""));
  const Outcome prediction = Run({"predict", Path("out/estimate.json"), bare, "--out=" + Path("predicted.csv")});
  ASSERT_EQ(prediction.status, 0) << prediction.err;
  const Rows rows = Cells(Read("predicted.csv"));
  EXPECT_NEAR(std::stod(rows[1][Column(rows, "pred_rx_mrad")]), predicted, 1e-6);
  const double psig = std::stod(rows[1][Column(rows, "psig_rx_urad")]);
  EXPECT_GT(psig, 1.0);
  EXPECT_LT(psig, 200.0);

  const Outcome validated =
      Run({"validate", Path("out/estimate.json"), Path("simulated.csv"), "--out=" + Path("validation")});
  ASSERT_EQ(validated.status, 0) << validated.err;
  const nlohmann::json validation = ReadJson("validation/validation.json");
  EXPECT_LT(validation["validation"]["rotation_rms_mrad"].get<double>(), 0.2);
  const Outcome inspected = Run({"inspect", calibration, "--out=" + Path("inspection")});
  EXPECT_EQ(inspected.status, 0) << inspected.err;
}

TEST_F(PoseCommandTest, RotationsWithoutSigmaAreSaid) {
  Simulate();
  Rows rows = Cells(Read("simulated.csv"));
  const size_t column = static_cast<size_t>(Column(rows, "sigma_rot_urad"));
  for (auto& row : rows) row.erase(row.begin() + static_cast<long>(column));
  const std::string file = Write("unstated.csv", Csv(rows));
  ASSERT_EQ(Run({"calibrate", Published("kr270/robot.yaml"), file, "--out=" + Path("out")}).status, 0);
  const std::string warnings = ReadJson("out/estimate.json")["warnings"].dump();
  EXPECT_NE(warnings.find("calibrate assumes 1 mrad, that of 1 mm over 1 m"), std::string::npos) << warnings;
  const Outcome weighed = Run({"calibrate", Write("w.yaml", Scene(file, "weights: equal\n")), "--out=" + Path("no")});
  EXPECT_EQ(weighed.status, 2);
  EXPECT_NE(weighed.err.find("weights"), std::string::npos) << weighed.err;
}

TEST_F(PoseCommandTest, MeasuredTorquesAreAskedForByFileLineAndKey) {
  const Outcome outcome =
      Run({"calibrate", Write("exp.yaml", Scene(Published("kr270/geometric.csv"), "torques: measured\n")),
           "--out=" + Path("out")});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("geometric.csv:"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("tau1_Nm"), std::string::npos) << outcome.err;
  EXPECT_FALSE(Exists("out/estimate.json"));
}

}  // namespace
}  // namespace sagitta::test::pose_command_test
