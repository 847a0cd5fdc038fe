// What diagnosis says of the noise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/diagnosis/noise_check.h"
#include "estimator/report/diagnosis_words.h"
#include "estimator/results/prediction_noise.h"
#include "estimator/sagitta.h"
#include "estimator/statistics/distributions.h"
#include "tests/support/hidden_kr270.h"

namespace sagitta::diagnosed_noise_test {
namespace {

using test::Hidden;
using test::Moved;

TEST(Diagnosis, WrongStatedNoiseIsAFindingAndNoEffect) {
  CalibrationProblem problem = Hidden(3, [](double) { return 0.0; });
  for (Observation& observation : problem.mutable_data()->observations) observation.sigma *= 0.5;
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNoise);
  EXPECT_TRUE(diagnosis.effects.empty());
  EXPECT_LT(diagnosis.noise.low, 2.0);
  EXPECT_GT(diagnosis.noise.high, 2.0);
  // Rows to come that state their noise as wrongly have the factor, too.
  const KnownRobot known = KnownFrom(ExtendedCalibration(diagnosis));
  EXPECT_GT(known.noise.instrument_factor * known.noise.scale, diagnosis.noise.low);
  EXPECT_LT(known.noise.instrument_factor * known.noise.scale, diagnosis.noise.high);
  // With an effect that is added, too.
  const CalibrationProblem& found = *diagnosis.final.problem;
  const CalibrationProblem extended = found.WithEffects({{"joint_harmonic", "A2", {{"order", "1"}}, {0.0, 0.0}}});
  EXPECT_EQ(extended.stated_noise_factor, found.stated_noise_factor);
}

// Of one marker three times what is stated. 180 coordinates less their part of the unknowns: sigma of the logarithm
// 5.5 %.
TEST(Diagnosis, AMarkerThatIsReadWithOtherNoiseIsAFinding) {
  CalibrationProblem problem = Hidden(3, [](double) { return 0.0; });
  for (Observation& observation : problem.mutable_data()->observations) {
    if (observation.marker == 1) observation.sigma /= 3.0;
  }
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNoise);
  ASSERT_EQ(diagnosis.noise.groups.size(), 1u);
  const GroupFinding& group = diagnosis.noise.groups[0];
  EXPECT_EQ(group.kind, ReadingGroup::Kind::kMarker);
  EXPECT_EQ(group.name, problem.data().markers[1]);
  EXPECT_TRUE(group.is_finding);
  EXPECT_NEAR(std::log(group.factor / 3.0), 0.0, 4.0 * 0.06);
  EXPECT_NEAR(std::log(group.high / group.low), 2.0 * 1.96 * 0.06, 0.1);
  EXPECT_FALSE(diagnosis.noise.scale_differs);
  const CalibrationProblem& found = *diagnosis.final.problem;
  EXPECT_EQ(found.WithEffects({}).scaled_groups.size(), 1u);
  // Rows to come have it, too.
  const KnownRobot known = KnownFrom(ExtendedCalibration(diagnosis));
  const Measurements& data = problem.data();
  const Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Constant(3, static_cast<long>(data.observations.size()), 1.0);
  const NoiseRoots roots = PredictionRoots(problem, known.noise, points);
  for (size_t i = 0; i < roots.size(); ++i) {
    const double factor = data.observations[i].marker == 1 ? group.factor : 1.0;
    EXPECT_NEAR(roots[i](0, 0), factor * data.observations[i].sigma.x(), 1e-9 * roots[i](0, 0));
  }
}

// An instrument that is better along one axis than the one figure that is stated of all: described, no mistake.
TEST(Diagnosis, LessNoiseInOneDirectionThanStatedIsNoFinding) {
  CalibrationProblem problem = Hidden(3, [](double) { return 0.0; });
  for (Observation& observation : problem.mutable_data()->observations) observation.sigma.z() *= 3.0;
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kConsistent);
  EXPECT_TRUE(std::isnan(diagnosis.gap.closed));  // nothing but the noise differs
  EXPECT_TRUE(std::isnan(diagnosis.gap.closed_ci95.low));
  ASSERT_EQ(diagnosis.noise.groups.size(), 1u);
  EXPECT_EQ(diagnosis.noise.groups[0].kind, ReadingGroup::Kind::kAxis);
  EXPECT_EQ(diagnosis.noise.groups[0].name, "z");
  EXPECT_NEAR(std::log(3.0 * diagnosis.noise.groups[0].factor), 0.0, 4.0 * 0.06);
}

// Joints that come to rest 40 urad (standard deviation) away from where they should, and nobody said so. Of 20
// intervals at 95 %, fewer than 15 hold the truth once in 3000. About 35 x 6 deviations less 50 unknowns determine the
// size: 5.6 % each, 1.3 % for the mean.
TEST(Diagnosis, UndeclaredRepeatabilityIsMeasured) {
  constexpr double kTruth = 40e-6;
  constexpr int kTrials = 20;
  int inside = 0;
  double sum = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::mt19937_64 random(700 + trial);
    std::normal_distribution<double> rest(0.0, kTruth);
    const CalibrationProblem problem = Moved(10 + trial, [&](Eigen::VectorXd* q) {
      for (double& joint : *q) joint += rest(random);
    });
    const Estimate estimate = EstimateJointly(problem, JointOptions());
    const RepeatabilityFit fit = FitRepeatability(problem, estimate.parameters, false, true);
    inside += fit.turn.low <= kTruth && kTruth <= fit.turn.high;
    sum += fit.turn.sigma;
  }
  EXPECT_GE(inside, 15);
  EXPECT_NEAR(sum / kTrials, kTruth, 0.05 * kTruth);
}

// Deviations of joints about as large as the instrument's noise move all markers of an arrival alike: mistaken for
// white noise they are anybody's effect. Every pose is visited once: an error that follows the pose would look the
// same, and that is said.
TEST(Diagnosis, DeviatingJointsAreNoEffect) {
  for (int trial = 0; trial < 3; ++trial) {
    std::mt19937_64 random(40 + trial);
    std::normal_distribution<double> rest(0.0, 15e-6);
    const CalibrationProblem stated = Moved(60 + trial, [&](Eigen::VectorXd* q) {
      for (double& joint : *q) joint += rest(random);
    });
    CalibrationProblem open = stated;
    for (Observation& observation : open.mutable_data()->observations) observation.sigma.setZero();
    for (const CalibrationProblem* problem : std::vector<const CalibrationProblem*>{&stated, &open}) {
      const Diagnosis diagnosis = Diagnose(*problem, DiagnosisOptions());
      EXPECT_TRUE(diagnosis.effects.empty());
      EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kUnknown);
      EXPECT_FALSE(diagnosis.noise.is_distinguished_from_pose);
      EXPECT_GT(diagnosis.noise.probability, 0.5);
      EXPECT_LT(diagnosis.noise.turn.low, 15e-6);
      EXPECT_GT(diagnosis.noise.turn.high, 15e-6);
      if (problem == &open) continue;
      // What may be an error that follows the pose is gap, not noise.
      EXPECT_EQ(diagnosis.gap.floor, diagnosis.baseline.estimate.noise_floor);
      EXPECT_EQ(diagnosis.final.estimate.chi2, diagnosis.baseline.estimate.chi2);  // nothing is believed in its place
    }
  }
}

// A model that is fitted as if the joints came to rest 10 urad away, and they do 40: its own residuals say that, and
// the fit goes by it then. Nothing stated of sigma, the instrument's is found with it. 35 x 6 deviations less 50
// unknowns: 5.6 % of standard deviation, four of them to either side.
TEST(Diagnosis, AModelHasTheRepeatabilityOfItsOwnResiduals) {
  constexpr double kTruth = 40e-6;
  for (const bool is_stated : {true, false}) {
    std::mt19937_64 random(91);
    std::normal_distribution<double> rest(0.0, kTruth);
    CalibrationProblem problem = WithRepeatability(Moved(92,
                                                         [&](Eigen::VectorXd* q) {
                                                           for (double& joint : *q) joint += rest(random);
                                                         }),
                                                   {10e-6, 0.0});
    const double factor = is_stated ? 1.0 : 0.5;
    if (!is_stated) problem = WithScaledSigmas(problem, factor);
    const DiagnosedModel model = FitFully(problem, JointOptions());
    ASSERT_GT(std::abs(model.estimate.chi2 / model.estimate.dof - 1.0), 0.3);
    const DiagnosedModel own = WithOwnRepeatability(model, is_stated, JointOptions());
    EXPECT_NEAR(own.estimate.chi2 / own.estimate.dof, 1.0, 0.15);
    for (const double sigma : own.problem->latent.sigmas) EXPECT_NEAR(std::log(sigma / kTruth), 0.0, 4.0 * 0.056);
    const double scale = own.problem->SqrtCovariance(0)(0, 0) / problem.SqrtCovariance(0)(0, 0);
    EXPECT_NEAR(std::log(scale * factor), 0.0, is_stated ? 1e-12 : 0.3);
  }
}

// Next to an effect that is named, too: the deviation that may follow the pose is in the gap, before and after.
TEST(Diagnosis, DeviatingJointsNextToAnEffectAreGap) {
  std::mt19937_64 random(45);
  std::normal_distribution<double> rest(0.0, 15e-6);
  const Diagnosis diagnosis = Diagnose(Moved(65,
                                             [&](Eigen::VectorXd* q) {
                                               (*q)[2] += 400e-6 * std::cos((*q)[2]);
                                               for (double& joint : *q) joint += rest(random);
                                             }),
                                       DiagnosisOptions());
  ASSERT_FALSE(diagnosis.effects.empty());
  ASSERT_FALSE(diagnosis.noise.is_distinguished_from_pose);
  ASSERT_GT(diagnosis.noise.turn.sigma, 0.0);
  EXPECT_LT(diagnosis.baseline.estimate.noise_floor, diagnosis.final.estimate.noise_floor);
  EXPECT_EQ(diagnosis.gap.floor, diagnosis.baseline.estimate.noise_floor);
  // What may follow the pose is wrong in predictions, too.
  EXPECT_GT(ExtendedCalibration(diagnosis).trust.noise.beyond_noise, 0.5 * diagnosis.gap.after);
}

// The joints deviate as stated and the instrument scatters twice as much: sigma is wrong, the repeatability is not.
TEST(Diagnosis, StatedRepeatabilityBesideAWrongSigmaIsNoFinding) {
  constexpr double kStated = 20e-6;
  std::mt19937_64 random(81);
  std::normal_distribution<double> rest(0.0, kStated);
  const CalibrationProblem measured = Moved(82, [&](Eigen::VectorXd* q) {
    for (double& joint : *q) joint += rest(random);
  });
  Measurements data = measured.data();
  for (Observation& observation : data.observations) observation.sigma *= 0.5;
  Experiment experiment = measured.experiment();
  for (const Joint& joint : measured.robot().chain.joints) {
    experiment.repeatability.angle.per_joint[joint.name] = kStated;
  }
  const Diagnosis diagnosis = Diagnose(MakeCalibrationProblem(measured.robot(), data, experiment), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNoise);
  // The gap is of the figures that stand next to it; noise closes none.
  const double floor = diagnosis.gap.floor, rms = HoldoutRms(diagnosis.final);
  EXPECT_NEAR(diagnosis.gap.after, std::sqrt(std::max(0.0, rms * rms - floor * floor)), 1e-12);
  EXPECT_TRUE(std::isnan(diagnosis.gap.closed));
  EXPECT_TRUE(std::isnan(diagnosis.gap.closed_ci95.low));
  EXPECT_TRUE(diagnosis.noise.scale_differs);
  EXPECT_FALSE(diagnosis.noise.HasUndeclaredRepeatability());
  EXPECT_LT(diagnosis.noise.low, 2.0);
  EXPECT_GT(diagnosis.noise.high, 2.0);
}

// The joints deviate as stated and the instrument scatters half as much: one factor of both would have the joints
// deviate less than they do.
TEST(Diagnosis, JointsDeviateAsStatedWhereSigmaAloneIsOverstated) {
  constexpr double kStated = 60e-6;
  std::mt19937_64 random(85);
  std::normal_distribution<double> rest(0.0, kStated);
  const CalibrationProblem measured = Moved(86, [&](Eigen::VectorXd* q) {
    for (double& joint : *q) joint += rest(random);
  });
  Measurements data = measured.data();
  for (Observation& observation : data.observations) observation.sigma *= 2.0;
  Experiment experiment = measured.experiment();
  for (const Joint& joint : measured.robot().chain.joints) {
    experiment.repeatability.angle.per_joint[joint.name] = kStated;
  }
  const Diagnosis diagnosis = Diagnose(MakeCalibrationProblem(measured.robot(), data, experiment), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNoise);
  EXPECT_TRUE(diagnosis.noise.scale_differs);
  EXPECT_FALSE(diagnosis.noise.HasUndeclaredRepeatability());
  EXPECT_LT(diagnosis.noise.low, 0.5);
  EXPECT_GT(diagnosis.noise.high, 0.5);
  EXPECT_NEAR((diagnosis.final.problem->latent.sigmas.array() / kStated - 1.0).abs().maxCoeff(), 0.0, 0.02);
}

// Both scatter twice as much as stated: the harmonic is found all the same, in the full model too, which has to be
// given twice both.
TEST(Diagnosis, AnEffectNextToNoiseThatIsStatedHalfAsLargeIsNamed) {
  constexpr double kStated = 60e-6;
  std::mt19937_64 random(83);
  std::normal_distribution<double> rest(0.0, 2.0 * kStated);
  const CalibrationProblem measured = Moved(84, [&](Eigen::VectorXd* q) {
    (*q)[2] += 1e-3 * std::cos((*q)[2]);
    for (double& joint : *q) joint += rest(random);
  });
  Measurements data = measured.data();
  for (Observation& observation : data.observations) observation.sigma *= 0.5;
  Experiment experiment = measured.experiment();
  for (const Joint& joint : measured.robot().chain.joints) {
    experiment.repeatability.angle.per_joint[joint.name] = kStated;
  }
  const Diagnosis diagnosis = Diagnose(MakeCalibrationProblem(measured.robot(), data, experiment), DiagnosisOptions());
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.effects[0].candidate.spec.effect, "joint_harmonic");
  EXPECT_TRUE(diagnosis.noise.scale_differs);
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
}

// Rows that scatter so much more than stated that it is chance one time in 3000: the posterior has a prior of one in
// twenty against a wrong sigma, but what else is left is no better explained by a cause.
CalibrationProblem ScatteringMore(const CalibrationProblem& problem, double squares, double dof) {
  const double factor = std::sqrt(squares / ChiSquareQuantile(1.0 - 1.0 / 3000.0, dof));
  CalibrationProblem more = problem;
  for (Observation& observation : more.mutable_data()->observations) observation.sigma *= factor;
  return more;
}

TEST(Diagnosis, MoreScatterThanStatedIsNoCauseWithoutAName) {
  const CalibrationProblem healthy = Hidden(3, [](double) { return 0.0; });
  const Estimate fit = FitFully(healthy, JointOptions()).estimate;
  const Diagnosis diagnosis = Diagnose(ScatteringMore(healthy, fit.chi2, fit.dof), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNoise) << VerdictInWords(diagnosis);
  EXPECT_TRUE(diagnosis.noise.scale_differs);
}

TEST(Diagnosis, MoreScatterThanStatedNextToAnEffectIsNoRest) {
  const CalibrationProblem hidden = Hidden(3, [](double q) { return 400e-6 * std::cos(q); });
  const Estimate with = Diagnose(hidden, DiagnosisOptions()).final.estimate;
  const Diagnosis diagnosis = Diagnose(ScatteringMore(hidden, with.chi2, with.dof), DiagnosisOptions());
  EXPECT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained) << VerdictInWords(diagnosis);
  EXPECT_TRUE(diagnosis.noise.scale_differs);
}

// `repeatability: estimate` asks of joints of both kinds, whichever the robot has; found is that of those that turn.
TEST(Diagnosis, ARepeatabilityThatIsAskedOfBothKindsIsFound) {
  CalibrationProblem problem = Hidden(3, [](double) { return 0.0; });
  RepeatabilitySpec& spec = problem.mutable_experiment()->repeatability;
  spec.angle.estimate = spec.length.estimate = true;
  const CalibrationProblem found = WithRepeatability(problem, {40e-6, 0.0});
  ASSERT_EQ(found.latent.size(), problem.robot().num_joints());
  EXPECT_NEAR((found.latent.sigmas.array() - 40e-6).abs().maxCoeff(), 0.0, 1e-15);
}

}  // namespace
}  // namespace sagitta::diagnosed_noise_test
