// All stages of paper 002 as one experiment file and one solve
// (problems/published/kr270/all_stages.yaml, simulated by make_kr270.py).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/statistics/distributions.h"
#include "models/constants.h"
#include "problems/io/experiment_file.h"
#include "problems/io/files.h"
#include "problems/io/measurement_file.h"
#include "problems/io/robot_file.h"
#include "tests/support/paths.h"

namespace sagitta::all_stages_test {
namespace {

using nlohmann::json;

const std::string kFolder = test::SourceFolder() + "/problems/published/kr270/";

CalibrationProblem AllStages() {
  const Experiment experiment = ReadExperimentFile(kFolder + "all_stages.yaml");
  const Robot robot = ReadRobotFile(experiment.robot_file);
  return MakeCalibrationProblem(robot, ReadMeasurementsFor(robot, experiment.measurement_files), experiment);
}

class AllStagesTest : public ::testing::Test {
 protected:
  static json Read(const std::string& name) { return json::parse(ReadTextFile(kFolder + name)); }

  // SI; stations and P markers of truth.json, the rest of loaded_truth.json.
  double Truth(const std::string& name) const {
    const size_t first = name.find('/'), last = name.rfind('/');
    const std::string family = name.substr(0, first), leaf = name.substr(last + 1);
    const std::string owner = first == last ? "" : name.substr(first + 1, last - first - 1);
    const int axis = leaf.back() - 'x';
    if (family == "geometry") {
      const json& entry = geometry_["geometry"][leaf];
      return entry.contains("value_mm") ? 1e-3 * entry["value_mm"].get<double>()
                                        : kDegree * entry["value_deg"].get<double>();
    }
    if (family == "base") {
      const json& station = owner == "S3" ? loaded_["stations"]["S3"] : geometry_["stations"][owner];
      if (leaf.size() == 1) return 1e-3 * station["xyz_mm"][axis].get<double>();
      return owner == "S3" ? 1e-3 * station["rotvec_mrad"][axis].get<double>()
                           : kDegree * station["rotvec_deg"][axis].get<double>();
    }
    if (family == "marker") {
      if (owner[0] == 'P') return 1e-3 * geometry_["markers"][owner]["xyz_mm"][axis].get<double>();
      if (owner[0] == 'K') return 1e-3 * loaded_["link_markers"][owner]["xyz_mm"][axis].get<double>();
      return 1e-3 * loaded_["markers"][owner][axis].get<double>();
    }
    if (family == "compliance") return 1e-6 * loaded_["compliance_urad_per_Nm"][leaf[1] - '1'].get<double>();
    return leaf == "Kc" ? 1e3 * loaded_["spring"]["Kc_N_per_mm"].get<double>()
                        : 1e-3 * loaded_["spring"][leaf + "_mm"].get<double>();
  }

  const json geometry_ = Read("truth.json"), loaded_ = Read("loaded_truth.json");
};

TEST_F(AllStagesTest, OneSolveCoversTheTruth) {
  const CalibrationProblem problem = AllStages();
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  // 3 bases, 3 + 3 flange markers, 2 link markers, 18 errors, k1 ... k6, the spring's five.
  EXPECT_EQ(estimate.estimated.size(), 71u);
  EXPECT_LE(estimate.iterations, 10);
  EXPECT_GT(estimate.sigma.p_value, 1e-3);
  EXPECT_LT(estimate.sigma.p_value, 1 - 1e-3);
  EXPECT_EQ(estimate.deflection_before.observations, 63);  // 45 hung, 18 pulled
  EXPECT_LT(estimate.deflection_after.rms, 0.06e-3);       // sigma sqrt(2) = 0.042 mm
  Eigen::VectorXd z(estimate.estimated.size());
  const Eigen::VectorXd sigma = estimate.covariance.diagonal().cwiseSqrt();
  for (int c = 0; c < z.size(); ++c) {
    const ParameterEstimate& row = estimate.table[estimate.estimated[c]];
    z[c] = (row.value - Truth(row.name)) / sigma[c];
    EXPECT_LT(std::abs(z[c]), 4.5) << row.name;
  }
  const Eigen::VectorXd inverse = sigma.cwiseInverse();
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * estimate.covariance * inverse.asDiagonal();
  const double p = ChiSquareSurvival(z.dot(correlation.ldlt().solve(z)), z.size());
  EXPECT_GT(p, 1e-3);
  EXPECT_LT(p, 1 - 1e-3);
}

TEST_F(AllStagesTest, ThePullsAreWhatTellsK1) {
  const CalibrationProblem problem = AllStages();
  const Estimate all = EstimateJointly(problem);
  Measurements fewer = problem.data();
  fewer.shots.clear();
  fewer.observations.clear();
  for (const Shot& shot : problem.data().shots) {
    if (shot.load == "HX" || shot.load == "HY") continue;
    Shot kept = shot;
    kept.observations.clear();
    for (const int i : shot.observations) {
      Observation observation = problem.data().observations[i];
      observation.shot = static_cast<int>(fewer.shots.size());
      kept.observations.push_back(static_cast<int>(fewer.observations.size()));
      fewer.observations.push_back(observation);
    }
    fewer.shots.push_back(kept);
  }
  const Estimate without = EstimateJointly(MakeCalibrationProblem(problem.robot(), fewer, problem.experiment()));
  ASSERT_TRUE(IsUsable(without.status)) << without.message;
  const int k1 = all.parameters.FindCoordinate("compliance/A1");
  EXPECT_GT(without.table[k1].sigma, 3 * all.table[k1].sigma);
}

}  // namespace
}  // namespace sagitta::all_stages_test
