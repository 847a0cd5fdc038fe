// A calibrated problem that is given other rows: what was found of each of the old rows is not theirs.
#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "estimator/sagitta.h"
#include "tests/support/in_memory.h"

namespace sagitta::other_rows_test {
namespace {

constexpr double kRepeatability = 2e-5;  // rad
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Every configuration twice at one arrival, so that shots and visits differ in number.
Measurements RowsReadTwice() {
  const Measurements once = test::ReadingsInMemory(test::ArmInMemory());
  Measurements twice = once;
  twice.shots.clear(), twice.observations.clear();
  for (const Shot& shot : once.shots) {
    for (const char* repeat : {"1", "2"}) {
      Shot again = shot;
      again.repeat = repeat;
      again.observations.clear();
      for (const int i : shot.observations) {
        Observation row = once.observations[i];
        row.shot = static_cast<int>(twice.shots.size());
        row.point_in_station.array() += repeat[0] == '1' ? 1e-5 : -1e-5;
        again.observations.push_back(static_cast<int>(twice.observations.size()));
        twice.observations.push_back(row);
      }
      twice.shots.push_back(again);
    }
  }
  return twice;
}

// One visit per shot, all three markers, not measured.
Measurements RowsAt(const std::vector<Eigen::VectorXd>& poses) {
  Measurements rows;
  rows.stations = {"S1"};
  rows.markers = {"M1", "M2", "M3"};
  for (int i = 0; i < static_cast<int>(poses.size()); ++i) {
    rows.configurations.push_back({"n" + std::to_string(i), poses[i], false});
    Shot shot;
    shot.configuration = i;
    shot.station = 0;
    for (int m = 0; m < 3; ++m) {
      Observation row;
      row.shot = i;
      row.marker = m;
      row.point_in_station.setConstant(kNan);
      row.sigma.setConstant(3e-5);
      shot.observations.push_back(static_cast<int>(rows.observations.size()));
      rows.observations.push_back(row);
    }
    rows.shots.push_back(shot);
  }
  return rows;
}

std::vector<Eigen::VectorXd> Poses(int count) {
  std::vector<Eigen::VectorXd> poses;
  for (int i = 0; i < count; ++i) {
    Eigen::VectorXd q(6);
    for (int j = 0; j < 6; ++j) q[j] = std::sin(1.0 + 7.0 * i + 3.0 * j);
    poses.push_back(q);
  }
  return poses;
}

std::vector<int> All(size_t count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// trace(J' S^-1 J), S = s^2 1 + t^2 D D' per shot, D by differences of points as the joints turn.
double InformationByDefinition(const CalibrationProblem& problem, const ParameterSet& parameters,
                               const std::vector<int>& columns, const std::vector<Eigen::VectorXd>& poses) {
  const std::vector<int> rows = All(9 * poses.size() / 3);
  const Linearization at = Linearize(problem, parameters, rows, columns,
                                     NoiseRoots(rows.size(), Matrix3<double>::Identity()), LatentTreatment::kIgnore);
  constexpr double kStep = 1e-5;
  std::vector<Eigen::Matrix3Xd> by_joint;
  for (int j = 0; j < 6; ++j) {
    Eigen::Matrix3Xd points[2];
    for (const int side : {0, 1}) {
      std::vector<Eigen::VectorXd> turned = poses;
      for (Eigen::VectorXd& q : turned) q[j] += side == 0 ? -kStep : kStep;
      CalibrationProblem moved = problem;
      moved.set_data(RowsAt(turned));
      moved.RenewShots();
      points[side] = PredictPoints(moved, parameters, rows);
    }
    by_joint.push_back((points[1] - points[0]) / (2.0 * kStep));
  }
  double trace = 0.0;
  for (int s = 0; s < static_cast<int>(poses.size()); ++s) {
    Eigen::MatrixXd d(9, 6);
    for (int j = 0; j < 6; ++j) d.col(j) = by_joint[j].middleCols(3 * s, 3).reshaped();
    const Eigen::MatrixXd j = at.jacobian.middleRows(9 * s, 9);
    const Eigen::MatrixXd noise =
        9e-10 * Eigen::MatrixXd::Identity(9, 9) + kRepeatability * kRepeatability * d * d.transpose();
    trace += (j.transpose() * noise.llt().solve(j)).trace();
  }
  return trace;
}

// With more and with fewer shots than before.
TEST(OtherRows, DeviateByVisitsOfTheirOwn) {
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kNone;
  experiment.repeatability.angle.common = kRepeatability;
  const Calibration calibrated = Calibrate(MakeCalibrationProblem(test::ArmInMemory(), RowsReadTwice(), experiment));
  ASSERT_TRUE(IsUsable(calibrated.estimate.status));
  const std::vector<int> columns = calibrated.estimate.parameters.EstimatedCoordinates();
  for (const int count : {10, 30, 200}) {
    const std::vector<Eigen::VectorXd> poses = Poses(count);
    CalibrationProblem problem = calibrated.problem;
    problem.set_data(RowsAt(poses));
    problem.RenewShots();
    ASSERT_EQ(problem.latent.num_visits, count);
    ASSERT_EQ(static_cast<int>(problem.latent.visit_of_shot.size()), count);
    EXPECT_EQ(problem.latent.sigmas, calibrated.problem.latent.sigmas);
    const std::vector<int> rows = All(problem.data().observations.size());
    const Linearization at = Linearize(problem, calibrated.estimate.parameters, rows, columns,
                                       ObservationNoise(problem, rows, kFallbackSigma));
    const double expected = InformationByDefinition(problem, calibrated.estimate.parameters, columns, poses);
    // Central differences with a step of 1e-5 rad: 1e-10 of a point, 2e-5 of its motion.
    EXPECT_NEAR((at.jacobian.transpose() * at.jacobian).trace(), expected, 1e-6 * expected) << count;
  }
}

TEST(OtherRows, WeighAsTheyState) {
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kNone;
  experiment.noise.from = NoiseSpec::From::kRepeats;
  const CalibrationProblem old = MakeCalibrationProblem(test::ArmInMemory(), RowsReadTwice(), experiment);
  ASSERT_EQ(old.resolved_noise.size(), old.data().observations.size());
  CalibrationProblem problem = old;
  problem.weight_roots = old.resolved_noise;
  problem.set_data(RowsAt(Poses(80)));
  problem.RenewShots();
  EXPECT_TRUE(problem.resolved_noise.empty());
  EXPECT_TRUE(problem.weight_roots.empty());
  const std::vector<int> rows = All(problem.data().observations.size());
  for (const Matrix3<double>& root : ObservationNoise(problem, rows, 1.0)) {
    EXPECT_NEAR(root(0, 0), 3e-5, 1e-12);
  }
  // Changed in place.
  problem = old;
  *problem.mutable_data() = RowsAt(Poses(80));
  problem.RenewShots();
  EXPECT_TRUE(problem.resolved_noise.empty());
  EXPECT_EQ(problem.latent.num_visits, 80);
  // The same rows with another split: what was found of them stays.
  problem = old;
  problem.mutable_data()->configurations[0].is_validation = true;
  problem.RenewShots();
  EXPECT_EQ(problem.resolved_noise.size(), old.resolved_noise.size());
}

}  // namespace
}  // namespace sagitta::other_rows_test
