// Compliances from measured joint torques, of rows that a generator of its own made.
#include <gtest/gtest.h>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/inspection/torque_lint.h"
#include "problems/input_error.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/stated_torques.h"

namespace sagitta::measured_torque_test {
namespace {

constexpr std::array<double, 6> kCompliance = {0.6e-6, 0.3e-6, 0.4e-6, 2.8e-6, 3.5e-6, 2.1e-6};

// Each joint gives way by k times its torque, wherever that is from: no load is stated.
Measurements RowsWithTorques(const test::Kr270Truth& truth) {
  Measurements data = test::DesignWithTorques();
  for (const Shot& shot : data.shots) {
    const Eigen::VectorXd& q = data.configurations[shot.configuration].q;
    Eigen::VectorXd bent = q;
    for (int j = 0; j < 6; ++j) bent[j] += kCompliance[j] * shot.joint_torques[j];
    for (const int i : shot.observations) {
      Observation& row = data.observations[i];
      row.point_in_station = test::ExactPoint(truth, bent, row.marker, shot.station);
    }
  }
  return data;
}

Experiment WithMeasuredTorques() {
  Experiment experiment;
  experiment.torques_measured = true;
  return experiment;
}

TEST(MeasuredTorque, CompliancesAreRecovered) {
  const test::Kr270Truth truth;
  const CalibrationProblem problem = test::Kr270ProblemOf(RowsWithTorques(truth), WithMeasuredTorques());
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  for (int j = 0; j < 6; ++j) {
    const std::string name = "compliance/A" + std::to_string(j + 1);
    const int i = estimate.parameters.FindCoordinate(name);
    ASSERT_GE(i, 0) << name << ": every joint's torque is known, so all are free";
    EXPECT_NEAR(estimate.table[i].value, kCompliance[j], 1e-8 * kCompliance[j]) << name;
    EXPECT_TRUE(estimate.table[i].identifiable);
  }
  for (const ParameterEstimate& row : estimate.table) {
    if (row.name.rfind("geometry/", 0) != 0) continue;
    EXPECT_NEAR(row.value, test::TrueValue(truth, row.name), 1e-9) << row.name;
  }
}

TEST(MeasuredTorque, IsAskedForWhereARowHasNone) {
  Measurements data = RowsWithTorques(test::Kr270Truth());
  data.shots[7].joint_torques.resize(0);
  const int row = data.observations[data.shots[7].observations[0]].row;
  try {
    test::Kr270ProblemOf(data, WithMeasuredTorques());
    FAIL() << "a row without torques was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.where().file, "simulated.csv");
    EXPECT_EQ(error.where().line, data.files[0].rows[row].line);
    EXPECT_EQ(error.where().key, "tau1_Nm");
  }
}

// Rows under a load, and torques as a sensor would show them: the model's, in another sign, or in another size.
TEST(MeasuredTorque, IsComparedWithTheModelInWords) {
  const test::LoadedTruth truth = test::Everything();
  test::LoadedDesign design;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), 0.0, 1, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  setup.robot.gravity_compensator.reset();
  setup.experiment.estimate.gravity_compensator = Selection();
  const CalibrationProblem loads = MakeCalibrationProblem(setup.robot, data, setup.experiment);
  const std::vector<double> theta = loads.parameters.ModelValues();
  const auto compared = [&](double factor) {
    CalibrationProblem problem = loads;
    for (size_t s = 0; s < problem.data().shots.size(); ++s) {
      const Matrix3<double> base = problem.parameters.BaseInStation(problem.data().shots[s].station).rotation;
      problem.mutable_data()->shots[s].joint_torques =
          factor * problem.model().ModelledJointTorques(problem.shot_inputs()[s], theta.data(), base);
    }
    return CompareTorques(problem, problem.parameters);
  };
  const TorqueComparison equal = compared(1.0);
  ASSERT_EQ(equal.joints.size(), 6u);
  EXPECT_FALSE(equal.joints[0].varies) << "weights ask nothing of an upright axis";
  for (const JointTorqueComparison& line : equal.joints) {
    if (line.joint == 0) continue;
    EXPECT_TRUE(line.varies);
    EXPECT_NEAR(line.slope, 1.0, 1e-12);
    EXPECT_NEAR(line.correlation, 1.0, 1e-12);
    EXPECT_NEAR(line.difference_rms, 0.0, 1e-12);
  }
  EXPECT_NE(equal.words.find("agree on A2"), std::string::npos) << equal.words;
  EXPECT_NE(equal.words.find("does not vary the torque on A1"), std::string::npos) << equal.words;
  EXPECT_NE(compared(-1.0).words.find("opposite signs on A2"), std::string::npos);
  EXPECT_NE(compared(1.6).words.find("measured = 1.6 x modelled"), std::string::npos);
  EXPECT_TRUE(TorquesOffByAFactor(equal, 0.01).empty());
  const std::vector<ScaledTorque> off = TorquesOffByAFactor(compared(1.6), 0.01);
  ASSERT_EQ(off.size(), 5u);
  EXPECT_NEAR(off[0].slope, 1.6, 1e-9);
  TorqueComparison unsure = compared(1.6);
  for (JointTorqueComparison& line : unsure.joints) line.slope_sigma = 0.2;
  EXPECT_TRUE(TorquesOffByAFactor(unsure, 0.01).empty()) << "1.6 may be 1.2 then";
  EXPECT_TRUE(CompareTorques(loads, loads.parameters).joints.empty()) << "no row states torques";
}

}  // namespace
}  // namespace sagitta::measured_torque_test
