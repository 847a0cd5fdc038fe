// Poses that are proposed, against what the rivals would show there by their formulas.
#include "estimator/evidence/next_poses.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

#include "estimator/diagnosis/diagnose.h"
#include "models/constants.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::next_poses_test {
namespace {

constexpr double kSigma = 2e-5;             // m
constexpr double kGain = 80e-6;             // rad/rad
constexpr double kLimit = 100.0 * kDegree;  // of joint 3, where it may go
constexpr double kSeenPart = 0.25;          // of the campaign's angles of joint 3

// Joint 3 moves little and its encoder has a gain: over a small range a wave of one per turn looks the same.
CalibrationProblem SeenOverAPartOfTheRange() {
  const test::Kr270Design design = test::CampaignOf(60, 1, kSigma, 11);
  Measurements data = test::DesignMeasurements(design);
  for (Configuration& configuration : data.configurations) configuration.q[2] *= kSeenPart;
  Measurements moved = data;
  for (Configuration& configuration : moved.configurations) configuration.q[2] *= 1.0 + kGain;
  test::MeasureKr270(test::Kr270Truth(), kSigma, 111, &moved);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    data.observations[i].point_in_station = moved.observations[i].point_in_station;
  }
  Robot robot = test::Kr270Robot();
  robot.chain.joints[2].min = -kLimit;
  robot.chain.joints[2].max = kLimit;
  return MakeCalibrationProblem(robot, data, Experiment());
}

// What the encoder's gain and the wave that is nearest to it on the measured angles differ by, rad.
class Difference {
 public:
  explicit Difference(const std::vector<Configuration>& measured) {
    Eigen::MatrixXd waves(static_cast<long>(measured.size()), 3);
    Eigen::VectorXd gain(static_cast<long>(measured.size()));
    for (size_t c = 0; c < measured.size(); ++c) {
      const double q = measured[c].q[2];
      waves.row(static_cast<long>(c)) << std::cos(q), std::sin(q), 1.0;
      gain[static_cast<long>(c)] = kGain * q;
    }
    wave_ = waves.colPivHouseholderQr().solve(gain);
  }

  double At(double q) const { return std::abs(kGain * q - wave_.dot(Eigen::Vector3d(std::cos(q), std::sin(q), 1.0))); }

 private:
  Eigen::Vector3d wave_;
};

// m, of the markers; the station is level.
double LowestPoint(const Eigen::VectorXd& q) {
  double lowest = kInfinity;
  for (const Vector3<double>& tool : test::Kr270Truth().tools)
    lowest = std::min(lowest, test::IndependentKr270Point(q, {}, tool).z());
  return lowest;
}

TEST(NextPoses, LieWhereTheRivalsDiffer) {
  const CalibrationProblem problem = SeenOverAPartOfTheRange();
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  ASSERT_TRUE(diagnosis.next.has_value());
  const std::vector<NamedSet>& sets = diagnosis.posterior.sets;
  ASSERT_GE(sets.size(), 2u);
  for (size_t k = 0; k < 2; ++k) {
    ASSERT_EQ(sets[k].specs.size(), 1u);
    EXPECT_EQ(sets[k].specs[0].target, "A3") << sets[k].specs[0].Path();
  }
  const Difference difference(problem.data().configurations);
  double lowest = kInfinity;  // of the points measured, over the foot
  for (const Configuration& configuration : problem.data().configurations)
    lowest = std::min(lowest, LowestPoint(configuration.q));
  for (const ProposedPose& pose : diagnosis.next->poses) EXPECT_GT(LowestPoint(pose.q), lowest - 2e-3);  // nominal arm
  double proposed = 0.0, anywhere = 0.0;
  for (const ProposedPose& pose : diagnosis.next->poses) {
    proposed += difference.At(pose.q[2]) / static_cast<double>(diagnosis.next->poses.size());
  }
  constexpr int kDrawn = 200;
  for (int k = 0; k < kDrawn; ++k) anywhere += difference.At(kLimit * (2.0 * (k + 0.5) / kDrawn - 1.0)) / kDrawn;
  EXPECT_GT(proposed, 1.5 * anywhere);
  EXPECT_GT(diagnosis.next->decides, diagnosis.next->decided);
  double together = 0.0;
  for (const NamedSet& rival : diagnosis.next->rivals) together += rival.probability;
  EXPECT_NEAR(diagnosis.next->of_probability, together, 1e-12);
  EXPECT_NEAR(diagnosis.next->rivals[0].probability, sets[0].probability, 0.01);
  EXPECT_FALSE(diagnosis.next->depends_on_when);
}

}  // namespace
}  // namespace sagitta::next_poses_test
