#include "estimator/baselines/full_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimator/alignment/pose_registration.h"
#include "estimator/baselines/two_step.h"
#include "estimator/calibration/joint_estimator.h"
#include "tests/support/agreement.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::full_pose_test {
namespace {

using test::Kr270Design;
using test::Kr270Truth;

Kr270Design Fine(double sigma, std::uint64_t seed) {
  Kr270Design design;
  design.stations = 1;
  design.sigma = sigma;
  design.seed = seed;
  return design;
}

// Markers at their true points, as a coordinate measuring machine would state them.
CalibrationProblem KnownTool(double sigma, std::uint64_t seed) {
  const Kr270Truth truth;
  Measurements data = test::DesignMeasurements(Fine(sigma, seed));
  test::MeasureKr270(truth, sigma, seed, &data);
  Robot robot;
  robot.chain = test::Kr270Chain();
  Experiment experiment;
  experiment.estimate.markers = false;
  experiment.estimate.geometry.kind = Selection::Kind::kAll;
  for (int m = 0; m < 3; ++m) experiment.markers["P" + std::to_string(m + 1)].point = truth.tools[m];
  return MakeCalibrationProblem(robot, data, experiment);
}

FullPoseOptions Propagated() {
  FullPoseOptions options;
  options.propagated_covariance = true;
  return options;
}

TEST(RegisterPose, RecoversAMotionAboutTheReference) {
  Eigen::Matrix3Xd points(3, 4);
  points << 0.1, -0.2, 0.3, 0.5, 0.0, 0.4, -0.1, 0.2, 0.2, 0.1, 0.0, -0.3;
  const Vector3<double> reference(0.7, -0.3, 1.1), shift(0.01, -0.02, 0.03), turn(0.2, -0.5, 0.3);
  const Eigen::Matrix3Xd turned = RotationFromVector(turn) * (points.colwise() - reference);
  const Eigen::Matrix3Xd targets = turned.colwise() + Vector3<double>(reference + shift);
  Vector6 expected;
  expected << shift, turn;
  const Eigen::VectorXd equal = Eigen::VectorXd::Ones(12), unequal = Eigen::VectorXd::LinSpaced(12, 1.0, 4.0);
  EXPECT_LT((RegisterPose(points, targets, equal, reference) - expected).norm(), 1e-12);
  EXPECT_LT((RegisterPose(points, targets, unequal, reference) - expected).norm(), 1e-12);
}

// With unequal sigmas the pose is the weighted optimum: whitened residuals are
// orthogonal to all six motions.
TEST(RegisterPose, WeightsItsRows) {
  Eigen::Matrix3Xd points(3, 4);
  points << 0.1, -0.2, 0.3, 0.5, 0.0, 0.4, -0.1, 0.2, 0.2, 0.1, 0.0, -0.3;
  Eigen::Matrix3Xd targets = points;
  targets.row(0) += Eigen::RowVector4d(1e-3, -2e-3, 3e-3, 1e-3);
  const Eigen::VectorXd sigmas = Eigen::VectorXd::LinSpaced(12, 1.0, 4.0);
  const Vector3<double> reference(0.7, -0.3, 1.1);
  const Vector6 motion = RegisterPose(points, targets, sigmas, reference);
  const Vector3<double> turn = motion.tail<3>();
  const Eigen::Matrix3Xd turned = RotationFromVector(turn) * (points.colwise() - reference);
  const Vector3<double> moved_reference = reference + motion.head<3>();
  const Eigen::Matrix3Xd moved = turned.colwise() + moved_reference;
  const Eigen::Matrix3Xd gap = targets - moved;
  const Eigen::VectorXd weighted =
      Eigen::Map<const Eigen::VectorXd>(gap.data(), 12).cwiseQuotient(sigmas.cwiseProduct(sigmas));
  EXPECT_LT((RigidColumns(moved, moved_reference).transpose() * weighted).norm(), 1e-12);
}

// The exact fact of PUBLISHED section 1: no information is lost in the poses. The
// standard deviations agree to 1e-6 (linear); the estimates differ by the curvature
// of rotations, of second order in noise / tool size: 1e-3 standard deviations at
// 0.01 mm, a hundredth of it at a hundredth of the noise.
TEST(FullPose, PropagatedCovarianceEqualsMarkerLeastSquares) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    double previous = 0.0;
    for (const double sigma : {1e-5, 1e-7}) {
      const CalibrationProblem problem = KnownTool(sigma, seed);
      const Estimate markers = EstimateJointly(problem);
      const Estimate poses = EstimateFromFullPoses(problem, Propagated());
      ASSERT_EQ(poses.status, Status::kConverged) << poses.message;
      for (const int c : markers.estimated) {
        EXPECT_NEAR(poses.table[c].sigma / markers.table[c].sigma, 1.0, 1e-6) << markers.table[c].name;
      }
      const double deviation = test::LargestDeviation(poses, markers);
      EXPECT_LT(deviation, 2e-3 * sigma / 1e-5);
      if (previous > 0.0) {
        EXPECT_NEAR(deviation / previous, 0.01, 0.003);
      }
      previous = deviation;
    }
  }
}

TEST(FullPose, PropagatedCovarianceEqualsMarkerLeastSquaresWithUnequalSigmas) {
  CalibrationProblem problem = KnownTool(1e-5, 4);
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    problem.mutable_data()->observations[i].sigma = Vector3<double>(1e-5, 3e-5, 0.5e-5) * (1.0 + 0.1 * (i % 7));
  }
  const Estimate markers = EstimateJointly(problem);
  const Estimate poses = EstimateFromFullPoses(problem, Propagated());
  EXPECT_LT(test::LargestDeviation(poses, markers), 1e-2);
  for (const int c : markers.estimated) {
    EXPECT_NEAR(poses.table[c].sigma / markers.table[c].sigma, 1.0, 1e-6) << markers.table[c].name;
  }
}

// Markers free: the shape from the data, the tool's place among the unknowns.
TEST(FullPose, UnknownToolCostsNothingEither) {
  const CalibrationProblem problem = test::Kr270Problem(Fine(1e-5, 2), Kr270Truth(), 5);
  const Estimate markers = EstimateJointly(problem);
  const Estimate poses = EstimateFromFullPoses(problem, Propagated());
  ASSERT_EQ(poses.status, Status::kConverged) << poses.message;
  EXPECT_LT(test::LargestDeviation(poses, markers), 3e-3);
  for (const int c : markers.estimated) {
    if (markers.table[c].name.rfind("marker/", 0) == 0) continue;  // their shape counts as known
    EXPECT_NEAR(poses.table[c].sigma / markers.table[c].sigma, 1.0, 1e-6) << markers.table[c].name;
  }
}

// Approach #1 with any weight is never better and stays honest about it: its own
// standard deviations describe its errors.
TEST(FullPose, StatedWeightIsNeverBetterAndUnbiased) {
  const Kr270Truth truth;
  for (const double weight : {0.1, 0.3, 1.0}) {
    FullPoseOptions options;
    options.weight = weight;
    double sum_of_squares = 0.0;
    int count = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const CalibrationProblem problem = KnownTool(1e-5, seed);
      const Estimate markers = EstimateJointly(problem);
      const Estimate poses = EstimateFromFullPoses(problem, options);
      ASSERT_EQ(poses.status, Status::kConverged) << poses.message;
      for (const int c : markers.estimated) {
        const double sigma = poses.table[c].sigma / std::max(1.0, poses.sigma.scaled ? poses.sigma.a_posteriori : 1.0);
        EXPECT_GT(sigma / markers.table[c].sigma, 1.0 - 1e-6) << markers.table[c].name;
        const double z = (poses.table[c].value - test::TrueValue(truth, poses.table[c].name)) / sigma;
        sum_of_squares += z * z;
        ++count;
      }
    }
    // 20 sets of 24 strongly correlated numbers: about 20 * 8 independent ones.
    EXPECT_NEAR(sum_of_squares / count, 1.0, 0.4) << weight;
  }
}

TEST(FullPose, RefusesInWordsWithoutPoses) {
  CalibrationProblem problem = test::Kr270Problem(Fine(1e-5, 2), Kr270Truth(), 5);
  CalibrationProblem on_links = problem;
  on_links.set_marker_frame(1, 5);
  EXPECT_NE(EstimateFromFullPoses(on_links).message.find("different links"), std::string::npos);
  CalibrationProblem held = problem;
  held.parameters.coordinate(held.parameters.FindCoordinate("marker/P1/x")).held = true;
  EXPECT_NE(EstimateFromFullPoses(held).message.find("all or none"), std::string::npos);
  CalibrationProblem two_markers = problem;
  for (Shot& shot : two_markers.mutable_data()->shots) shot.observations.pop_back();
  std::vector<Observation>& observations = two_markers.mutable_data()->observations;
  observations.erase(std::remove_if(observations.begin(), observations.end(),
                                    [](const Observation& observation) { return observation.marker == 2; }),
                     observations.end());
  const Estimate none = EstimateFromFullPoses(two_markers);
  EXPECT_FALSE(IsUsable(none.status));
  EXPECT_NE(none.message.find("no full pose"), std::string::npos) << none.message;
}

}  // namespace
}  // namespace sagitta::full_pose_test
