// Poses whose rotations state no noise while that of points is known: from an instrument, one figure, few repeats, next
// to joints that deviate. What is found of rotations, and that it is called what it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/agreement/part_fits.h"
#include "estimator/calibration/noise_loop.h"
#include "estimator/diagnosis/diagnose.h"
#include "estimator/noise/rotation_noise.h"
#include "estimator/report/noise_words.h"
#include "estimator/sagitta.h"
#include "tests/support/hidden_kr270.h"
#include "tests/support/kr270_poses.h"

namespace sagitta::unstated_rotations_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kPoint = 5e-5;     // m
constexpr double kRotation = 2e-5;  // rad, a fiftieth of what is assumed
constexpr int kConfigurations = 60;

Measurements Poses(double rotation, unsigned seed = 83, double stated = 0.0) {
  return test::NoisyPoses(kConfigurations, {stated, 0.0}, {kPoint, rotation}, seed);
}

// The first `pairs` configurations are shot once more: two readings with noise of their own about what was exact.
Measurements WithRepeats(Measurements data, double rotation, int pairs, unsigned seed) {
  const test::TargetTruth target;
  const test::Kr270Truth truth = test::TurnedTruth();
  NormalNumbers normal(seed);
  for (int c = 0; c < pairs; ++c) {
    const int point = test::AppendRepeat(c, &data);
    Observation &moved = data.observations[point], &turned = data.observations[point + 1];
    const Pose<double> exact = test::ExactPose(truth, target, data.ConfigurationOf(moved).q, data.shots[c].station);
    Vector3<double> off, turn;
    for (int i = 0; i < 3; ++i) off[i] = kPoint * normal();
    for (int i = 0; i < 3; ++i) turn[i] = rotation * normal();
    moved.point_in_station = turned.point_in_station = exact.translation + off;
    turned.mutable_rotation()->in_station = RotationFromVector(turn) * exact.rotation;
  }
  return data;
}

Experiment With(NoiseSpec::From from) {
  Experiment experiment;
  experiment.noise.from = from;
  if (from == NoiseSpec::From::kInstrument) experiment.noise.range = experiment.noise.angle = kPoint;
  if (from == NoiseSpec::From::kSigma) experiment.noise.sigma = kPoint;
  return experiment;
}

void ExpectNothingMissing(const Measurements& data, const Experiment& experiment, const char* what) {
  const Diagnosis diagnosis = Diagnose(test::Kr270ProblemOf(data, experiment), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kConsistent) << what;
  EXPECT_TRUE(diagnosis.effects.empty()) << what;
  // As rotations scatter it is written, and a reading to come has it. 180 numbers, less some 20 unknowns: 5.6 %.
  const KnownRobot known = KnownFrom(ExtendedCalibration(diagnosis));
  EXPECT_NEAR(known.noise.scale * known.noise.instrument_factor * known.noise.sigma_rotation.x(), kRotation,
              5.0 * 0.056 * kRotation)
      << what;
}

// Rotations that scatter by far less than the 1 mrad that is assumed of them are no missing effect, whatever the noise
// of points is from.
TEST(UnstatedRotations, AreNoMissingEffectWhateverPointsGoBy) {
  using From = NoiseSpec::From;
  ExpectNothingMissing(Poses(kRotation), With(From::kSigma), "one figure");
  ExpectNothingMissing(Poses(kRotation), With(From::kInstrument), "an instrument");
  ExpectNothingMissing(Poses(kRotation), With(From::kVarianceComponents), "variance components");
  ExpectNothingMissing(WithRepeats(Poses(kRotation), kRotation, 3, 7), With(From::kRepeats), "repeats");
  Experiment deviating = With(From::kSigma);
  deviating.repeatability.angle.common = 1e-6;  // 3 um at 3 m: next to nothing
  ExpectNothingMissing(Poses(kRotation), deviating, "repeatability");
  Experiment robust = With(From::kSigma);
  robust.method.loss = LossKind::kHuber;
  ExpectNothingMissing(Poses(kRotation), robust, "a loss");
}

// Three pairs of repeats know the noise of points to a quarter, the residuals that of rotations to a twentieth: the
// figure of rotations is theirs. By the points' it would scatter by 20 % from campaign to campaign.
TEST(UnstatedRotations, AreKnownByTheirResidualsNextToFewRepeats) {
  constexpr double kTruth = 1e-4;
  double squares = 0.0;
  int campaigns = 0;
  for (unsigned seed = 1; seed <= 10; ++seed, ++campaigns) {
    const Measurements data = WithRepeats(Poses(kTruth, seed), kTruth, 3, 100 + seed);
    const ResolvedEstimate found = EstimateWithNoise(test::Kr270ProblemOf(data, With(NoiseSpec::From::kRepeats)));
    const RepeatScatter& repeats = *found.problem.repeat_scatter;
    const SigmaReport& sigma = found.estimate.sigma;
    ASSERT_TRUE(repeats.rotation_is_estimated);
    const double applied = (sigma.scaled ? sigma.a_posteriori : 1.0) * repeats.rotation_sigma.x();
    squares += std::pow(applied / kTruth - 1.0, 2);
    EXPECT_GT(repeats.rotation_dof, 140.0);
  }
  // Relative variance 1 / (2 f) each with f = 165; chi-square with 10 is below 30 in all but one of 1000.
  EXPECT_LT(squares / campaigns, 3.0 / (2.0 * 165.0));
}

// w^2 of points over what the fit leaves of these, sum (1 - h), whatever it leaves of rotations.
TEST(UnstatedRotations, TheUnitOfPointsHasTheirLeverage) {
  test::Kr270Design design;
  const Measurements data = test::NoisyPoses(16, {kPoint, 0.0}, {kPoint, 1e-3}, 5);
  Experiment experiment;
  const CalibrationProblem problem = test::Kr270ProblemOf(data, experiment);
  const Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status));
  double squares = 0.0, freedom = 0.0;
  for (const int i : problem.data().PointsAmong(problem.CalibrationObservations())) {
    squares += (problem.data().observations[i].point_in_station - estimate.predicted.col(i)).squaredNorm();
    freedom += 3.0 * (1.0 - estimate.leverage[i]);
  }
  const auto scatter = FindRotationScatter(problem, problem, estimate, true);
  ASSERT_TRUE(scatter);
  EXPECT_NEAR(scatter->unit, std::sqrt(squares / freedom) / kPoint, 1e-6);
  EXPECT_EQ(FindRotationScatter(problem, problem, estimate, false)->unit, 1.0);
}

// Joints that deviate as stated move rotations too: what is left to these is found next to that, and not assumed.
TEST(UnstatedRotations, AreFoundNextToJointsThatDeviate) {
  constexpr double kTruth = 1e-4, kJoints = 2e-5;
  Measurements data = WithRepeats(Poses(kTruth), kTruth, 3, 7);
  // Each visit is off by the turns of its joints: both readings of a pair alike.
  const test::TargetTruth target;
  const test::Kr270Truth truth = test::TurnedTruth();
  NormalNumbers normal(3);
  std::vector<Eigen::VectorXd> off(data.configurations.size());
  for (Eigen::VectorXd& joints : off) {
    joints.resize(6);
    for (double& joint : joints) joint = kJoints * normal();
  }
  for (Observation& row : data.observations) {
    const Shot& shot = data.shots[row.shot];
    const Eigen::VectorXd& q = data.ConfigurationOf(row).q;
    const Pose<double> there = test::ExactPose(truth, target, q, shot.station);
    const Pose<double> stopped = test::ExactPose(truth, target, q + off[shot.configuration], shot.station);
    row.point_in_station += stopped.translation - there.translation;
    if (row.is_point()) continue;
    Eigen::Matrix3d& turned = row.mutable_rotation()->in_station;
    turned = turned * there.rotation.transpose() * stopped.rotation;
  }
  Experiment experiment = With(NoiseSpec::From::kRepeats);
  experiment.repeatability.angle.common = kJoints;
  const ResolvedEstimate found = EstimateWithNoise(test::Kr270ProblemOf(data, experiment));
  ASSERT_TRUE(IsUsable(found.estimate.status)) << found.estimate.message;
  for (const std::string& warning : found.estimate.warnings) EXPECT_THAT(warning, Not(HasSubstr("too few")));
  const RepeatScatter& repeats = *found.problem.repeat_scatter;
  EXPECT_TRUE(repeats.rotation_is_estimated);
  EXPECT_NEAR(repeats.rotation_sigma.x(), kTruth, 4.0 * 0.07 * kTruth);
}

// Where a target is points say alone, by three pairs: 9 degrees of freedom in whatever parts are compared. How it is
// turned rotations say, with the some 165 of their residuals.
TEST(UnstatedRotations, PartsAreComparedByWhatTheirParametersRestOn) {
  const Measurements data = WithRepeats(Poses(1e-4), 1e-4, 3, 7);
  const ResolvedEstimate found = EstimateWithNoise(test::Kr270ProblemOf(data, With(NoiseSpec::From::kRepeats)));
  ASSERT_FALSE(found.estimate.sigma.scaled);
  const Whole whole(found.problem, found.estimate, nullptr);
  ASSERT_EQ(whole.dof_by_repeats.size(), static_cast<Eigen::Index>(found.estimate.estimated.size()));
  int places = 0, turns = 0;
  for (size_t i = 0; i < found.estimate.estimated.size(); ++i) {
    const std::string& name = found.problem.parameters.coordinates()[found.estimate.estimated[i]].name;
    const double dof = whole.dof_by_repeats[static_cast<Eigen::Index>(i)];
    if (name.rfind("marker/T/r", 0) == 0) {
      EXPECT_GT(dof, 36.0) << name;
      ++turns;
    } else if (name.rfind("marker/T/", 0) == 0) {
      EXPECT_LT(dof, 20.0) << name;
      ++places;
    }
  }
  EXPECT_EQ(places, 3);
  EXPECT_EQ(turns, 3);
}

// Nothing states the noise: what the diagnosis found is no statement, and no share of the residuals is the robot's.
TEST(UnstatedRotations, NoiseThatADiagnosisFoundIsNotCalledStated) {
  CalibrationProblem problem = test::Hidden(3, [](double) { return 0.0; });
  for (Observation& row : problem.mutable_data()->observations) row.sigma.setZero();
  const Calibration open = ExtendedCalibration(Diagnose(problem, DiagnosisOptions()));
  const auto json = CalibrationToJson(open, {});
  EXPECT_FALSE(json["sigma"]["stated"].get<bool>());
  EXPECT_EQ(json["noise"]["source"], "estimated");
  EXPECT_EQ(json["sigma"]["estimated_mm"], json["prediction_noise"]["sigma_mm"]);
  EXPECT_EQ(NameOfNoise(open.estimate.sigma.origin), "the noise that was found");
  EXPECT_TRUE(open.trust.noise.of_residuals);
  EXPECT_EQ(open.trust.noise.noise, 0.0);
  EXPECT_LT(open.estimate.interval_dof.maxCoeff(), open.estimate.rows) << "Student's: from these rows";

  CalibrationProblem half = test::Hidden(3, [](double) { return 0.0; });
  for (Observation& row : half.mutable_data()->observations) row.sigma *= 0.5;
  const Calibration found = ExtendedCalibration(Diagnose(half, DiagnosisOptions()));
  EXPECT_TRUE(CalibrationToJson(found, {})["sigma"]["stated"].get<bool>());
  EXPECT_THAT(SigmaInWords(found.estimate, 0.01), HasSubstr("agree with the noise that was found"));
  EXPECT_EQ(found.trust.noise.noise, 0.0);
  for (const std::string& limit : found.trust.limits) EXPECT_THAT(limit, Not(HasSubstr("stated standard deviations")));

  const Calibration right =
      ExtendedCalibration(Diagnose(test::Hidden(3, [](double) { return 0.0; }), DiagnosisOptions()));
  EXPECT_THAT(SigmaInWords(right.estimate, 0.01), HasSubstr("agree with the stated sigmas"));
  EXPECT_GT(right.trust.noise.noise, 0.0);
}

TEST(UnstatedRotations, RepeatsAreNotCalledStated) {
  const Measurements data = WithRepeats(Poses(1e-4), 1e-4, 14, 7);
  const ResolvedEstimate found = EstimateWithNoise(test::Kr270ProblemOf(data, With(NoiseSpec::From::kRepeats)));
  EXPECT_THAT(SigmaInWords(found.estimate, 0.01), HasSubstr("the scatter of the repeats"));
}

}  // namespace
}  // namespace sagitta::unstated_rotations_test
