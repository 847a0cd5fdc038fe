// Estimates from poses of a target: against the truth of a generator of its own, and against the points of three
// markers that say the same.
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include <numeric>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/intervals/redraw.h"
#include "estimator/least_squares/ceres_problem.h"
#include "estimator/least_squares/linearization.h"
#include "tests/support/kr270_poses.h"

namespace sagitta::pose_estimate_test {
namespace {

using test::Kr270Design;
using test::Kr270Truth;
using test::TargetTruth;

// Every row as the truth has it, with the noise of `error` (position, then left perturbation).
void MeasurePoses(const Kr270Truth& truth, const TargetTruth& target,
                  const std::function<Eigen::Matrix<double, 6, 1>(const Pose<double>&)>& error, Measurements* data) {
  for (Observation& row : data->observations) {
    if (!row.is_point()) continue;
    const int station = data->shots[row.shot].station;
    const Pose<double> exact = test::ExactPose(truth, target, data->ConfigurationOf(row).q, station);
    const Eigen::Matrix<double, 6, 1> off = error(exact);
    Observation& rotation = data->observations[row.partner];
    row.point_in_station = rotation.point_in_station = exact.translation + off.head<3>();
    const Vector3<double> turn = off.tail<3>();
    rotation.mutable_rotation()->in_station = RotationFromVector(turn) * exact.rotation;
  }
}

Eigen::Matrix<double, 6, 1> NoError(const Pose<double>&) { return Eigen::Matrix<double, 6, 1>::Zero(); }

std::map<std::string, ParameterEstimate> ByName(const Estimate& estimate) {
  std::map<std::string, ParameterEstimate> rows;
  for (const ParameterEstimate& row : estimate.table) rows[row.name] = row;
  return rows;
}

TEST(PoseEstimate, ExactPosesGiveTheTruth) {
  const Kr270Truth truth = test::TurnedTruth();
  const TargetTruth target;
  Measurements data = test::PoseRows(Kr270Design());
  MeasurePoses(truth, target, NoError, &data);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  for (const ParameterEstimate& row : estimate.table) {
    if (row.name.rfind("geometry/", 0) != 0) continue;
    EXPECT_NEAR(row.value, test::TrueValue(truth, row.name), 1e-10) << row.name;
  }
  EXPECT_LT((estimate.parameters.MarkerPoint(0) - target.point).norm(), 1e-10);
  EXPECT_LT((estimate.parameters.MarkerRotation(0) - target.rotation).norm(), 1e-10);
  EXPECT_EQ(estimate.fit.observations, 18) << "a pose is one observation";
  EXPECT_EQ(estimate.fit.rotations, 18);
  EXPECT_EQ(estimate.rows, 6 * 18);
  EXPECT_LT(estimate.fit.rotation_max, 1e-11);
  EXPECT_GT(estimate.fit_before.rotation_rms, 1e-4) << "the nominal robot is off by its angular errors";
}

// The same noise said in two ways. Three points at a + R u_k with isotropic sigma, sum of u_k = 0, hold the pose (a, R)
// with covariance sigma^2 / 3 of a and sigma^2 (sum |u|^2 I - u u')^-1 of R, the latter in the target's frame; for an
// equilateral triangle of radius r: sigma^2 / r^2 diag(2/3, 2/3, 1/3). Misfits are small enough (1e-7 rad) that their
// squares do not matter at 1e-6 standard deviations.
TEST(PoseEstimate, EqualsThatOfThreeMarkersOfTheSamePoses) {
  constexpr double kSigma = 2e-8, kRadius = 0.12;
  Kr270Design design;
  design.configurations = 24;
  const Kr270Truth truth = test::TurnedTruth();
  const TargetTruth target;
  const Vector3<double> turn_sigma = kSigma / kRadius * Vector3<double>(2.0 / 3, 2.0 / 3, 1.0 / 3).cwiseSqrt();
  NormalNumbers normal(31);
  Measurements poses = test::PoseRows(design);
  MeasurePoses(
      truth, target,
      [&](const Pose<double>& exact) {
        Vector3<double> turn;
        Eigen::Matrix<double, 6, 1> off;
        for (int i = 0; i < 3; ++i) off[i] = kSigma / std::sqrt(3.0) * normal();
        for (int i = 0; i < 3; ++i) turn[i] = turn_sigma[i] * normal();
        off.tail<3>() = exact.rotation * turn;
        return off;
      },
      &poses);
  Measurements points = test::DesignMeasurements(design);
  for (Observation& row : points.observations) {
    const Observation& center = poses.observations[poses.shots[row.shot].observations[0]];
    const double angle = 2.0 * M_PI / 3.0 * row.marker;
    const Vector3<double> u = kRadius * Vector3<double>(std::cos(angle), std::sin(angle), 0.0);
    row.point_in_station = center.point_in_station + poses.observations[center.partner].rotation().in_station * u;
  }
  CalibrationProblem of_poses = test::Kr270ProblemOf(poses, Experiment());
  CalibrationProblem of_points = test::Kr270ProblemOf(points, Experiment());
  of_points.resolved_noise.assign(points.observations.size(), kSigma * Matrix3<double>::Identity());
  for (const Observation& row : poses.observations) {
    of_poses.resolved_noise.push_back(row.is_point()
                                          ? Matrix3<double>(kSigma / std::sqrt(3.0) * Matrix3<double>::Identity())
                                          : Matrix3<double>(row.rotation().in_station * turn_sigma.asDiagonal()));
  }
  const Estimate from_poses = EstimateJointly(of_poses), from_points = EstimateJointly(of_points);
  ASSERT_EQ(from_poses.status, Status::kConverged) << from_poses.message;
  ASSERT_EQ(from_points.status, Status::kConverged) << from_points.message;
  EXPECT_FALSE(from_poses.sigma.scaled || from_points.sigma.scaled) << "intervals by the stated noise";
  const auto same = ByName(from_points);
  int compared = 0;
  for (const ParameterEstimate& row : from_poses.table) {
    if (row.name.rfind("marker/", 0) == 0) continue;
    const ParameterEstimate& other = same.at(row.name);
    if (!row.free) continue;
    EXPECT_NEAR(row.value, other.value, 1e-6 * other.sigma) << row.name;
    EXPECT_NEAR(row.sigma, other.sigma, 1e-6 * other.sigma) << row.name;
    ++compared;
  }
  EXPECT_EQ(compared, 12 + 18);
}

// Residuals and Jacobian of rows of both kinds, in the linearization and in Ceres, against differences.
TEST(PoseEstimate, JacobianEqualsDifferences) {
  const Kr270Truth truth = test::TurnedTruth();
  Measurements data = test::PoseRows(Kr270Design());
  test::RandomNumbers random(12);
  MeasurePoses(
      truth, TargetTruth(),
      [&](const Pose<double>&) {  // far off, so that the misfits' own derivative counts
        Eigen::Matrix<double, 6, 1> off;
        off << random.Vector(0.01), random.Vector(0.5);
        return off;
      },
      &data);
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  ParameterSet parameters = problem.parameters;
  Eigen::VectorXd away(parameters.num_coordinates());
  for (double& value : away) value = random.Uniform(-0.02, 0.02);
  parameters.SetMarkerRotation(0, TargetTruth().rotation);
  parameters.Plus(away);
  const ResidualSelection rows = CalibrationResiduals(problem);
  const std::vector<int> columns = parameters.EstimatedCoordinates();
  const Linearization here = Linearize(problem, parameters, rows.observations, columns, rows.noise);
  ASSERT_EQ(here.num_rows(), 6 * 18);
  for (int c = 0; c < here.num_columns(); ++c) {
    const double step = 1e-5;
    const auto residual_at = [&](double x) {
      ParameterSet moved = parameters;
      Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters.num_coordinates());
      delta[columns[c]] = x;
      moved.Plus(delta);
      return Linearize(problem, moved, rows.observations, {}, rows.noise).residual;
    };
    const Eigen::VectorXd numeric =
        (8.0 * (residual_at(step) - residual_at(-step)) - (residual_at(2.0 * step) - residual_at(-2.0 * step))) /
        (12.0 * step);
    EXPECT_LE((here.jacobian.col(c) - numeric).norm(), 1e-6 * numeric.norm())
        << parameters.coordinates()[columns[c]].name;
  }
  ceres::Problem ceres_problem;
  AddToProblem(problem, rows, &parameters, &ceres_problem, nullptr);
  double cost = 0.0;
  std::vector<double> gradient;
  ASSERT_TRUE(ceres_problem.Evaluate(ceres::Problem::EvaluateOptions(), &cost, nullptr, &gradient, nullptr));
  EXPECT_NEAR(cost, 0.5 * here.residual.squaredNorm(), 1e-9 * cost);
  const Eigen::VectorXd expected = here.jacobian.transpose() * here.residual;
  const double sum = Eigen::Map<const Eigen::VectorXd>(gradient.data(), gradient.size()).norm();
  EXPECT_NEAR(sum, expected.norm(), 1e-9 * expected.norm());
}

// A target read as a pose and plain reflectors in one set of data.
TEST(PoseEstimate, PosesAndPointsMix) {
  const Kr270Truth truth = test::TurnedTruth();
  const TargetTruth target;
  Measurements data = test::PoseRows(Kr270Design());
  MeasurePoses(truth, target, NoError, &data);
  data.markers.push_back("P2");
  const size_t shots = data.shots.size();
  for (size_t s = 0; s < shots; s += 2) {
    Observation point;
    point.shot = static_cast<int>(s);
    point.marker = 1;
    point.sigma.setConstant(1e-4);
    point.file = 0;
    point.row = static_cast<int>(data.files[0].rows.size());
    data.files[0].rows.push_back({point.row + 2, {}});
    point.point_in_station = test::ExactPoint(truth, data.ConfigurationOf(point).q, 1, data.shots[s].station);
    data.shots[s].observations.push_back(static_cast<int>(data.observations.size()));
    data.observations.push_back(point);
  }
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_EQ(estimate.status, Status::kConverged) << estimate.message;
  EXPECT_LT((estimate.parameters.MarkerPoint(1) - truth.tools[1]).norm(), 1e-9);
  EXPECT_FALSE(estimate.parameters.is_oriented(1));
  EXPECT_LT(estimate.parameters.FindCoordinate("marker/P2/rx"), 0);
  EXPECT_GE(estimate.parameters.FindCoordinate("marker/T/rx"), 0);
  EXPECT_EQ(estimate.fit.observations, 18 + 9);
}

// Intervals: the squared distance to the truth in units of its covariance is chi-square where the noise is as stated.
TEST(PoseEstimate, CovarianceIsThatOfRedraws) {
  const Kr270Truth truth = test::TurnedTruth();
  const TargetTruth target;
  Measurements data = test::PoseRows(Kr270Design());
  MeasurePoses(truth, target, NoError, &data);
  CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const Estimate exact = EstimateJointly(problem);
  ASSERT_EQ(exact.status, Status::kConverged) << exact.message;
  const Simulator redraw = RedrawAt(problem, exact.parameters, 1.0, 1e-3);
  constexpr int kDraws = 40;
  double sum = 0.0;
  const auto n = static_cast<double>(exact.estimated.size());
  for (int i = 0; i < kDraws; ++i) {
    ASSERT_TRUE(redraw.Draw(SeedOf(9, i), problem.mutable_data()));
    const ResidualSelection rows = CalibrationResiduals(problem);
    const Linearization here = Linearize(problem, exact.parameters, rows.observations, exact.estimated, rows.noise);
    const LinearSolution solution = SolveLinearization(here);
    sum += solution.step.dot(solution.covariance.ldlt().solve(solution.step));
  }
  // The sum of kDraws chi-squares of n: mean n kDraws, variance 2 n kDraws; 4 standard deviations.
  EXPECT_NEAR(sum, n * kDraws, 4.0 * std::sqrt(2.0 * n * kDraws));
}

}  // namespace
}  // namespace sagitta::pose_estimate_test
