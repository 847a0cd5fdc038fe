#include "estimator/calibration/joint_estimator.h"

#include <gtest/gtest.h>

#include "estimator/least_squares/linearization.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/random_vector.h"

namespace sagitta::joint_estimator_test {
namespace {

using test::Kr270Design;
using test::Kr270Problem;
using test::Kr270Truth;
using test::TrueValue;

// (estimate - truth)' C^-1 (estimate - truth) over all estimated coordinates.
double SquaredMahalanobis(const Estimate& estimate, const Kr270Truth& truth) {
  Eigen::VectorXd error(estimate.estimated.size());
  for (int c = 0; c < error.size(); ++c) {
    const std::string& name = estimate.parameters.coordinates()[estimate.estimated[c]].name;
    error[c] = estimate.parameters.Value(estimate.estimated[c]) - TrueValue(truth, name);
  }
  const Eigen::VectorXd scale = estimate.covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation =
      scale.cwiseInverse().asDiagonal() * estimate.covariance * scale.cwiseInverse().asDiagonal();
  const Eigen::VectorXd z = error.cwiseQuotient(scale);
  return z.dot(correlation.ldlt().solve(z));
}

TEST(JointEstimator, RecoversExactDataToRoundOff) {
  const Kr270Truth truth;
  Kr270Design design;
  CalibrationProblem problem = Kr270Problem(design, truth, 1);
  test::MeasureKr270(truth, 0.0, 1, problem.mutable_data());  // no noise
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  EXPECT_EQ(estimate.estimated.size(), 39u);
  EXPECT_LE(estimate.iterations, 8);
  for (const ParameterEstimate& row : estimate.table) {
    EXPECT_NEAR(row.value, TrueValue(truth, row.name), 1e-9) << row.name;
  }
}

TEST(JointEstimator, RecoversAllUnknownsWithinTheirCovariance) {
  const Kr270Truth truth;
  const Estimate estimate = EstimateJointly(Kr270Problem(Kr270Design(), truth, 7));
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  EXPECT_EQ(estimate.identifiability.rank, 39);
  EXPECT_EQ(estimate.dof, 162 - 39);
  EXPECT_GT(ChiSquareSurvival(SquaredMahalanobis(estimate, truth), 39), 1e-5);
  EXPECT_GT(estimate.sigma.p_value, 1e-5);
}

// Leverage is the mean over three axes of the diagonal of J C J' V^-1, of which the trace is the number of parameters,
// with joints that are exact and with such as deviate.
TEST(JointEstimator, LeveragesAddUpToTheParameters) {
  const Kr270Design design;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(Kr270Truth(), design.sigma, 1, &data);
  for (const double deviates : {0.0, 40e-6}) {
    Experiment experiment;
    if (deviates > 0.0) experiment.repeatability.angle.common = deviates;
    const CalibrationProblem problem = test::Kr270ProblemOf(data, experiment);
    ASSERT_EQ(problem.latent.empty(), deviates == 0.0);
    const Estimate estimate = EstimateJointly(problem);
    ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
    double sum = 0.0;
    for (const int i : problem.CalibrationObservations()) sum += 3.0 * estimate.leverage[i];
    EXPECT_NEAR(sum, static_cast<double>(estimate.estimated.size()), 1e-5) << deviates;
  }
}

// 95 % intervals of 39 parameters in N trials: each count is binomial(N, 0.95).
// The bound is the two-sided binomial one for 39 parameters at once at 1e-4.
TEST(JointEstimator, IntervalsCoverAsTheyClaim) {
  constexpr int kTrials = 150;
  const Kr270Truth truth;
  CalibrationProblem problem = Kr270Problem(Kr270Design(), truth, 1);
  std::vector<int> covered(problem.parameters.num_coordinates(), 0);
  for (int trial = 0; trial < kTrials; ++trial) {
    test::MeasureKr270(truth, 1e-4, 1000 + trial, problem.mutable_data());
    const Estimate estimate = EstimateJointly(problem);
    ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
    for (size_t i = 0; i < estimate.table.size(); ++i) {
      const double value = TrueValue(truth, estimate.table[i].name);
      covered[i] += estimate.table[i].ci95.low <= value && value <= estimate.table[i].ci95.high;
    }
  }
  const double z = NormalQuantile(1.0 - 0.5e-4 / 39);
  const double slack = z * std::sqrt(0.95 * 0.05 / kTrials) + 0.5 / kTrials;
  for (size_t i = 0; i < covered.size(); ++i) {
    const double coverage = covered[i] / static_cast<double>(kTrials);
    EXPECT_NEAR(coverage, 0.95, slack) << problem.parameters.coordinates()[i].name;
  }
}

TEST(JointEstimator, AnyBaseRotationAndUnknownToolsConvergeToTheSameOptimum) {
  constexpr int kStarts = 200;
  test::RandomNumbers random(20);
  Kr270Design design;
  design.stations = 1;
  design.sigma = 1e-5;
  double reference_cost = -1.0;
  for (int k = 0; k < kStarts; ++k) {
    Kr270Truth truth;
    const Vector3<double> axis = random.Vector(1.0).normalized();
    truth.base_rotvec[0] = random.Uniform(0.0, kPi) * axis;
    truth.base_xyz[0] = random.Vector(5.0);
    CalibrationProblem problem = Kr270Problem(design, truth, 3);
    // The same noise seen from another base is other noise: rotate it along.
    test::MeasureKr270(truth, 0.0, 1, problem.mutable_data());
    NormalNumbers normal(5);
    for (Observation& observation : problem.mutable_data()->observations) {
      const Vector3<double> noise = test::RandomVector(normal);
      observation.point_in_station += RotationFromVector(truth.base_rotvec[0]) * noise * design.sigma;
    }
    const Estimate estimate = EstimateJointly(problem);
    ASSERT_EQ(estimate.status, Status::kConverged) << k << ": " << estimate.message;
    if (reference_cost < 0.0) reference_cost = estimate.cost;
    EXPECT_NEAR(estimate.cost, reference_cost, 1e-6 * reference_cost) << k;
  }
}

TEST(JointEstimator, SigmaIsEstimatedWhereNothingStatesIt) {
  const Kr270Truth truth;
  CalibrationProblem problem = Kr270Problem(Kr270Design(), truth, 11);
  for (Observation& observation : problem.mutable_data()->observations) observation.sigma.setZero();
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  EXPECT_FALSE(estimate.sigma.stated);
  // chi-square of 123 degrees of freedom: sigma within 4 of its standard deviations.
  EXPECT_NEAR(estimate.sigma.estimated, 1e-4, 4 * 1e-4 / std::sqrt(2.0 * 123));
}

TEST(JointEstimator, TooSmallStatedSigmaScalesTheIntervalsAndSaysSo) {
  const Kr270Truth truth;
  CalibrationProblem problem = Kr270Problem(Kr270Design(), truth, 12);
  for (Observation& observation : problem.mutable_data()->observations) observation.sigma.setConstant(1e-5);
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  EXPECT_TRUE(estimate.sigma.scaled);
  EXPECT_NEAR(estimate.sigma.a_posteriori, 10.0, 4 * 10.0 / std::sqrt(2.0 * 123));
  EXPECT_GT(ChiSquareSurvival(SquaredMahalanobis(estimate, truth) * 1.0, 39), 1e-5);
}

TEST(JointEstimator, OneCostPerMarkerAndPerShotAgree) {
  const CalibrationProblem problem = Kr270Problem(Kr270Design(), Kr270Truth(), 13);
  JointOptions per_marker;
  per_marker.granularity = CostGranularity::kMarker;
  const Estimate a = EstimateJointly(problem);
  const Estimate b = EstimateJointly(problem, per_marker);
  for (size_t i = 0; i < a.table.size(); ++i) {
    EXPECT_NEAR(a.table[i].value, b.table[i].value, 1e-6 * a.table[i].sigma) << a.table[i].name;
  }
}

TEST(JointEstimator, RedundantErrorIsHeldWithWords) {
  const Kr270Truth truth;
  Measurements data = test::DesignMeasurements(Kr270Design());
  test::MeasureKr270(truth, 1e-4, 3, &data);
  Robot robot;
  robot.chain = test::Kr270Chain();
  robot.chain.transforms.back().error = "p_x6";  // along the tool's x: one with every marker's x
  Experiment experiment;
  experiment.estimate.geometry.kind = Selection::Kind::kAll;
  const Estimate estimate = EstimateJointly(MakeCalibrationProblem(robot, data, experiment));
  ASSERT_EQ(estimate.status, Status::kConvergedWithHeldParameters) << estimate.message;
  ASSERT_EQ(estimate.identifiability.unidentifiable.size(), 1u);
  const Direction& direction = estimate.identifiability.unidentifiable[0];
  ASSERT_EQ(direction.components.size(), 4u);  // p_x6 and the x of three markers
  EXPECT_NE(direction.words.find("geometry/p_x6"), std::string::npos) << direction.words;
  EXPECT_NE(direction.words.find("marker/P2/x"), std::string::npos) << direction.words;
  const int held = estimate.parameters.FindCoordinate("geometry/p_x6");
  EXPECT_FALSE(estimate.table[held].identifiable);
  EXPECT_EQ(estimate.table[held].value, 0.0);
  EXPECT_NEAR(estimate.parameters.Value(estimate.parameters.FindCoordinate("geometry/p_x1")), truth.errors[0], 5e-4);
}

TEST(JointEstimator, MarkerSeenOnceIsNoError) {
  const Kr270Truth truth;
  Kr270Design design;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(truth, 1e-4, 3, &data);
  data.markers.push_back("once");
  data.observations[2].marker = 3;
  Robot robot;
  robot.chain = test::Kr270Chain();
  const Estimate estimate = EstimateJointly(MakeCalibrationProblem(robot, data, Experiment()));
  EXPECT_TRUE(IsUsable(estimate.status)) << estimate.message;
}

}  // namespace
}  // namespace sagitta::joint_estimator_test
