// An error that the model lacks and that is alike in all parts of the data: standard deviations of predicted points and
// of corrected targets know of it by what is left on points that were not fitted.
#include <gtest/gtest.h>

#include "estimator/intervals/prediction.h"
#include "estimator/sagitta.h"
#include "problems/input_error.h"
#include "tests/support/moved_kr270.h"
#include "tests/support/random_vector.h"

namespace sagitta::left_over_test {
namespace {

constexpr double kSigma = 5e-5;   // m
constexpr double kRipple = 5e-5;  // rad, 50 waves per turn on the first joint

Measurements Rippled(int configurations, std::uint64_t seed, double ripple) {
  const test::Kr270Design design = test::CampaignOf(configurations, 1, kSigma, seed);
  return test::MeasuredAfter(design, seed + 1,
                             [ripple](Eigen::VectorXd* q) { (*q)[0] += ripple * std::cos(50.0 * (*q)[0]); });
}

KnownRobot CalibratedOn(const Measurements& data) {
  const Calibration calibration = Calibrate(MakeCalibrationProblem(test::Kr270Robot(), data, Experiment()));
  EXPECT_TRUE(IsUsable(calibration.estimate.status)) << calibration.estimate.message;
  return KnownFrom(calibration);
}

// Mean square over coordinates of (predicted - true) / standard deviation on fresh poses, free of noise.
double SquareOfDeviations(double ripple) {
  const KnownRobot known = CalibratedOn(Rippled(200, 21, ripple));
  const test::Kr270Design design = test::CampaignOf(100, 1, 0.0, 99);
  Measurements fresh =
      test::MeasuredAfter(design, 1, [ripple](Eigen::VectorXd* q) { (*q)[0] += ripple * std::cos(50.0 * (*q)[0]); });
  for (Observation& row : fresh.observations) row.sigma.setConstant(kSigma);
  const Prediction prediction = Predict(known, fresh);
  double sum = 0.0;
  for (size_t k = 0; k < fresh.observations.size(); ++k) {
    const Vector3<double> off = prediction.points.col(static_cast<long>(k)) - fresh.observations[k].point_in_station;
    sum += off.cwiseQuotient(prediction.covariances[k].mean().diagonal().cwiseSqrt()).squaredNorm();
  }
  return sum / (3.0 * static_cast<double>(fresh.observations.size()));
}

// Parameters of 200 poses alone would be some ten times too sure: by squares, a hundred. What remains is that the
// ripple is larger at some poses than at others.
TEST(LeftOver, PredictedPointsAreKnownNoBetterThanUnseenOnesWere) {
  EXPECT_LT(SquareOfDeviations(kRipple), 1.5);
  EXPECT_GT(SquareOfDeviations(kRipple), 0.5);
}

// 33 parameters share the mean over 900 coordinates.
TEST(LeftOver, OfATrueModelNothingIsAdded) {
  const KnownRobot known = CalibratedOn(Rippled(200, 21, 0.0));
  EXPECT_EQ(known.rest, 0.0);
  EXPECT_NEAR(SquareOfDeviations(0.0), 1.0, 4.0 * std::sqrt(2.0 / 27.0));
}

TEST(LeftOver, IsAddedAlikeInAllDirections) {
  const Matrix3<double> covariance = Vector3<double>(1.0, 4.0, 4.0).asDiagonal();
  const Matrix3<double> added = AddedByRest(covariance, 6.0);
  EXPECT_LT((added - 9.0 * Matrix3<double>::Identity()).norm(), 1e-12);  // (36 - 9) / 3
  EXPECT_EQ(AddedByRest(covariance, 3.0), Matrix3<double>::Zero());
}

Targets TargetsAt(int count) {
  Targets targets;
  targets.shots = Rippled(count, 5, 0.0);
  for (const Shot& shot : targets.shots.shots) {
    Target target;
    target.q = targets.shots.ConfigurationOf(targets.shots.observations[shot.observations[0]]).q;
    targets.rows.push_back(target);
  }
  return targets;
}

// Where the flange goes does not depend on what the instrument reads. A slip that was found has happened.
TEST(CorrectedTargets, NeedNoColumnsOfWhatMovesNoFlange) {
  KnownRobot known = CalibratedOn(Rippled(200, 21, 0.0));
  const Targets targets = TargetsAt(3);
  const auto solved = [&] { return Compensate(MakeCompensationInput(known, targets), targets.rows, 1); };
  const std::vector<CompensatedTarget> plain = solved();
  known.robot.effects = {{"station_drift", "S1", {}, std::vector<double>(6, 1e-8)},
                         {"marker_shift", "P1", {{"after_s", "100"}}, std::vector<double>(3, 1e-3)}};
  const std::vector<CompensatedTarget> with_drift = solved();
  known.robot.effects.push_back({"joint_slip", "A2", {{"after_s", "5000"}}, {2e-3}});
  const std::vector<CompensatedTarget> with_slip = solved();
  for (size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(plain[i].solution.q, with_drift[i].solution.q);
    EXPECT_NEAR(plain[i].solution.q[1] - with_slip[i].solution.q[1], 2e-3, 1e-9);
  }
  // What goes on with time, and what the direction of approach decides, has to be stated.
  known.robot.effects.push_back({"learnt_lag", "A3", {{"by", "motion"}, {"lag_s", "600"}, {"unit", "1"}}, {1e-4}});
  EXPECT_THROW(solved(), InputError);
  known.robot.effects = {{"backlash", "A2", {}, {1e-3}}};
  EXPECT_THROW(solved(), InputError);
}

// 95 % of a distance whose coordinates have the variance r^2 / 3 each: r sqrt(7.8147 / 3), chi-square of three.
TEST(LeftOver, CorrectedTargetsAreKnownNoBetter) {
  KnownRobot known = CalibratedOn(Rippled(200, 21, 0.0));
  known.rest = 1e-3;
  const Targets targets = TargetsAt(3);
  for (const CompensatedTarget& target : Compensate(MakeCompensationInput(known, targets), targets.rows, 1))
    EXPECT_NEAR(target.u95_position, 1e-3 * std::sqrt(7.8147 / 3.0), 2e-6);
}

}  // namespace
}  // namespace sagitta::left_over_test
