// Cross-validation by one step against refits of each fold, suspect rows made for the purpose, the verdict.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/refit.h"
#include "estimator/report/validation_words.h"
#include "estimator/validation/trust.h"
#include "models/constants.h"
#include "tests/support/judged.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::validation_test {
namespace {

using test::Kr270Design;
using ::testing::HasSubstr;

CalibrationProblem Problem(const std::function<void(Measurements*)>& change = {}, const Experiment& experiment = {},
                           std::uint64_t seed = 1) {
  Kr270Design design;
  design.configurations = 30;
  design.seed = seed;
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 100 + seed, &data);
  if (change) change(&data);
  return test::Kr270ProblemOf(data, experiment);
}

TEST(CrossValidation, AgreesWithTenRefits) {
  const CalibrationProblem problem = Problem();
  const Estimate estimate = EstimateJointly(problem);
  const CrossValidation found = test::CrossValidate(problem, estimate, 1);
  ASSERT_EQ(found.folds, 10);
  const std::vector<int> fold_of = FoldsOf(problem, 1);
  const std::vector<int> observations = problem.CalibrationObservations();
  double squares = 0.0, most = 0.0;
  for (int fold = 0; fold < 10; ++fold) {
    RefitOptions options;
    std::vector<int> left_out;
    for (const int i : observations) {
      const bool is_out = fold_of[problem.data().shots[problem.data().observations[i].shot].configuration] == fold;
      options.weights.push_back(is_out ? 0.0 : 1.0);
      if (is_out) left_out.push_back(i);
    }
    ASSERT_FALSE(left_out.empty());
    const Refit refit = RefitFrom(problem, estimate.parameters, options);
    ASSERT_TRUE(refit.converged);
    const Eigen::Matrix3Xd predicted = PredictPoints(problem, refit.parameters, left_out);
    for (size_t k = 0; k < left_out.size(); ++k) {
      const double distance = (problem.data().observations[left_out[k]].point_in_station - predicted.col(k)).norm();
      squares += distance * distance;
      most = std::max(most, distance);
    }
  }
  const double refitted = std::sqrt(squares / observations.size());
  EXPECT_NEAR(found.unseen.distance_rms / refitted, 1.0, 0.02);
  EXPECT_NEAR(found.unseen.distance_max / most, 1.0, 0.02);
  EXPECT_GT(found.unseen.distance_rms, estimate.fit.distance_rms);
  // Stated noise, right model: errors as predicted. 270 coordinates: 4 standard errors are 17 %.
  EXPECT_NEAR(found.unseen.Excess(), 1.0, 0.17);
}

// Where all rows err by one sigma, from what is summed of each fold; else row by row.
TEST(CrossValidation, PredictsTheSameFromSumsAndRowByRow) {
  const CalibrationProblem problem = Problem();
  Estimate estimate = EstimateJointly(problem);
  const CrossValidation from_sums = test::CrossValidate(problem, estimate, 1);
  estimate.scatter[0] *= 1.0 + 1e-9;
  const CrossValidation row_by_row = test::CrossValidate(problem, estimate, 1);
  ASSERT_GT(row_by_row.unseen.predicted_rms, 0.0);
  EXPECT_NEAR(from_sums.unseen.predicted_rms / row_by_row.unseen.predicted_rms, 1.0, 1e-8);
  EXPECT_NEAR(from_sums.unseen.p_value, row_by_row.unseen.p_value, 1e-6);
}

TEST(Suspects, EachIsNamedWithWhatWouldMakeItFit) {
  const CalibrationProblem problem = Problem([](Measurements* data) {
    auto& rows = data->observations;
    std::swap(rows[9].point_in_station, rows[10].point_in_station);  // two markers of one shot
    rows[20].point_in_station.y() *= -1.0;
    rows[40].point_in_station *= 1e-3;
    rows[61].point_in_station.z() += 3e-3;
    // Both are nearer in a unit 1000 times smaller, and fit no better.
    rows[72].point_in_station.setConstant(-9.999);
    rows[80].point_in_station = {-9.9, -9.7, -9.999};
  });
  const Estimate estimate = EstimateJointly(problem);
  const std::vector<Suspect> suspects = FindSuspects(problem, estimate);
  std::map<std::string, std::string> words;
  for (const Suspect& suspect : suspects) words[suspect.row] = suspect.words;
  EXPECT_THAT(words["simulated.csv:11"], HasSubstr("marker names exchanged (simulated.csv:12)"));
  EXPECT_THAT(words["simulated.csv:12"], HasSubstr("marker names exchanged (simulated.csv:11)"));
  EXPECT_THAT(words["simulated.csv:22"], HasSubstr("y of the other sign"));
  EXPECT_THAT(words["simulated.csv:42"], HasSubstr("read in m"));
  EXPECT_THAT(words["simulated.csv:63"], HasSubstr("measure it again"));
  EXPECT_THAT(words["simulated.csv:74"], HasSubstr("one number, as of a lost reading: leave the three cells empty"));
  EXPECT_THAT(words["simulated.csv:82"], HasSubstr("measure it again"));
  EXPECT_EQ(suspects.size(), 7u);
}

// Two rows are no reason to doubt the robot file, however far they move everything.
TEST(Suspects, ARobotThatMissesBecauseOfThemIsNotDoubted) {
  const CalibrationProblem problem = Problem([](Measurements* data) {
    std::swap(data->observations[9].point_in_station, data->observations[10].point_in_station);
  });
  Estimate estimate = EstimateJointly(problem);
  const std::string verdict = test::JudgeTrust(problem, 1, &estimate).verdict.words;
  EXPECT_THAT(verdict, HasSubstr("correct these rows or leave them out"));
  EXPECT_THAT(verdict, ::testing::Not(HasSubstr("do not belong together")));
}

TEST(Trust, CleanDataAreTrustedAndKeepTheirIntervals) {
  int trusted = 0, wide = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const CalibrationProblem problem = Problem({}, {}, seed);
    Estimate estimate = EstimateJointly(problem);
    const Trust trust = test::JudgeTrust(problem, 1, &estimate);
    EXPECT_TRUE(trust.suspects.empty()) << trust.verdict.words;
    trusted += trust.verdict.trusted;
    wide += trust.model_error > 1.0;
    EXPECT_THAT(trust.verdict.words, HasSubstr("On poses it has not seen this robot is now within"));
  }
  EXPECT_EQ(trusted, 5);
  EXPECT_EQ(wide, 0);
}

TEST(Trust, HoldoutBeyondItsPredictionIsSaidAndInTheIntervals) {
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  CalibrationProblem problem = Problem({}, experiment);
  for (const int i : problem.ValidationObservations())
    problem.mutable_data()->observations[i].point_in_station.z() += (i % 2 == 0 ? 1.0 : -1.0) * 4e-4;
  Estimate estimate = EstimateJointly(problem);
  const Interval before = estimate.table[0].ci95;
  const Trust trust = test::JudgeTrust(problem, 1, &estimate);
  EXPECT_FALSE(trust.verdict.trusted);
  EXPECT_THAT(trust.verdict.words, HasSubstr("times what the estimate predicted"));
  EXPECT_GT(trust.model_error, 1.5);
  const Interval after = estimate.table[0].ci95;
  EXPECT_NEAR((after.high - after.low) / (before.high - before.low), trust.model_error, 1e-9);
  EXPECT_EQ(trust.ci95_noise_only[0].low, before.low);
}

// Noise that is stated as half of what it is: the residuals scale it by two, and what is lacking is counted beyond what
// is stated.
TEST(Trust, WhatRefutesTheStatedNoiseIsLackOfALearntModel) {
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  const CalibrationProblem problem = Problem(
      [](Measurements* data) {
        for (Observation& row : data->observations) row.sigma *= 0.5;
      },
      experiment);
  Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(estimate.sigma.scaled);
  const double scale = estimate.sigma.a_posteriori;
  ASSERT_NEAR(scale, 2.0, 0.3);
  const Trust trust = JudgeByHoldout(problem, &estimate);
  const double stated = trust.holdout.predicted_rms / scale, distance = trust.holdout.distance_rms;
  const double scatter = 3.0 * stated * stated * (1.0 - trust.holdout.parameters_share);
  EXPECT_NEAR(trust.noise.beyond_noise, std::sqrt(distance * distance - scatter), 1e-12);
}

// Gross rows among the fitted ones make the prediction too large for clean held-out points: that is no agreement.
TEST(Trust, APredictionThatIsTooLargeDoesNotAgree) {
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  CalibrationProblem problem = Problem({}, experiment);
  int k = 0;
  for (const int i : problem.CalibrationObservations())
    if (++k % 6 == 0) problem.mutable_data()->observations[i].point_in_station.z() += (k % 4 == 0 ? 1.0 : -1.0) * 2e-3;
  Estimate estimate = EstimateJointly(problem);
  const Trust trust = test::JudgeTrust(problem, 1, &estimate);
  ASSERT_LT(trust.Quoted().Excess(), 0.7);
  EXPECT_THAT(trust.verdict.words, HasSubstr(" times larger"));
  EXPECT_THAT(trust.verdict.words, ::testing::Not(HasSubstr("the prediction agrees")));
}

TEST(ModelError, OnceIsNoFactor) {
  const std::string words =
      ModelErrorInWords(1.01, 4.9, "geometry/j3.theta", "parts contradict each other", ExcessOf::kNone);
  EXPECT_THAT(words, ::testing::StartsWith("single intervals are up to 4.9 times as wide"));
  EXPECT_THAT(ModelErrorInWords(1.6, 9.6, "geometry/j2.a", "parts contradict each other", ExcessOf::kNone),
              ::testing::StartsWith("the intervals are 1.6 times as wide"));
}

TEST(Trust, PointsThatWereNeverMeasuredAreDoubted) {
  const CalibrationProblem problem =
      Problem([](Measurements* data) { test::MeasureKr270(test::Kr270Truth(), 1e-9, 3, data); });
  Estimate estimate = EstimateJointly(problem);
  const Trust trust = test::JudgeTrust(problem, 1, &estimate);
  EXPECT_FALSE(trust.verdict.trusted);
  EXPECT_THAT(trust.verdict.words, HasSubstr("below any instrument's noise"));
}

// A robot file that is as good as its own calibration is called that, not worse than itself.
TEST(Trust, ARobotFileThatIsCalibratedAlreadyIsAsGoodAsBefore) {
  CalibrationProblem problem = Problem();
  Estimate estimate = EstimateJointly(problem);
  estimate.aligned = estimate.parameters;
  ComputeStatistics(problem, &estimate);
  const Trust trust = test::JudgeTrust(problem, 1, &estimate);
  ASSERT_LT(trust.nominal.distance_rms, trust.Quoted().distance_rms);
  EXPECT_TRUE(trust.verdict.trusted) << trust.verdict.words;
  EXPECT_THAT(trust.verdict.words, HasSubstr("the robot file was as good already"));
}

// A joint that stands still in all rows is not measured, and the figures hold where it stands.
TEST(Trust, AJointThatStandsStillIsSaid) {
  const CalibrationProblem problem = Problem([](Measurements* data) {
    for (Configuration& configuration : data->configurations) configuration.q[5] = 0.5;
    test::MeasureKr270(test::Kr270Truth(), 5e-5, 7, data);
  });
  Estimate estimate = EstimateJointly(problem);
  const Trust trust = test::JudgeTrust(problem, 1, &estimate);
  EXPECT_TRUE(trust.verdict.trusted) << trust.verdict.words;
  EXPECT_THAT(trust.verdict.words, HasSubstr("Joint A6 stands at 28.6 deg in all rows: what it does was not measured"));
}

// 9 mm of a length, as by a typing error: estimated all the same, and said.
TEST(Trust, ACorrectionLargerThanArmsNeedIsSaid) {
  CalibrationProblem problem = Problem();
  Robot typed = problem.robot();
  const int a = typed.chain.FindError("p_x1");
  typed.chain.transforms[a].nominal += 9e-3;
  typed.dh.reset();
  const CalibrationProblem with = MakeCalibrationProblem(typed, problem.data(), problem.experiment());
  Estimate estimate = EstimateJointly(with);
  const Trust trust = test::JudgeTrust(with, 1, &estimate);
  EXPECT_THAT(trust.verdict.words, HasSubstr("geometry/p_x1 comes out 9"));
  Estimate clean = EstimateJointly(problem);
  EXPECT_THAT(test::JudgeTrust(problem, 1, &clean).verdict.words, ::testing::Not(HasSubstr("from the robot file")));
}

// One configuration alone tilts the flange: the fold that holds it out leaves the marker unmeasured, and the figure is
// that of a calibration without it, which holds what it does not determine.
TEST(CrossValidation, WhatOnlyOneConfigurationMeasuresIsHeldWhereItIsLeftOut) {
  const CalibrationProblem problem = Problem([](Measurements* data) {
    for (size_t c = 0; c < data->configurations.size(); ++c) {
      Eigen::VectorXd& q = data->configurations[c].q;
      if (c != 4) q.tail(3).setZero();
      if (c != 4) q[2] = 0.4 - q[1];
    }
    test::KeepFirstMarker(data);
    test::MeasureKr270(test::Kr270Truth(), 1e-4, 9, data);
  });
  const Estimate estimate = EstimateJointly(problem);
  const CrossValidation found = test::CrossValidate(problem, estimate, 1);
  const int fold = FoldsOf(problem, 1)[4];
  CalibrationProblem without = problem;
  for (Observation& row : without.mutable_data()->observations) {
    row.excluded |= FoldsOf(problem, 1)[problem.data().shots[row.shot].configuration] == fold;
  }
  const Estimate rest = EstimateJointly(without);
  double refitted = 0.0;
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    const Observation& row = problem.data().observations[i];
    if (row.excluded || problem.data().shots[row.shot].configuration != 4) continue;
    const Eigen::Matrix3Xd at = PredictPoints(problem, rest.parameters, {static_cast<int>(i)});
    refitted = (row.point_in_station - at.col(0)).norm();
  }
  ASSERT_GT(refitted, 10.0 * estimate.fit.distance_rms);  // it is not measured
  EXPECT_NEAR(found.unseen.distance_max / refitted, 1.0, 0.02);
}

// A robot file with learnt weights holds no prior of them. Estimated anew, one that a single row excites would go
// anywhere where that row is left out: they are kept unless they are asked for.
TEST(CrossValidation, LearntWeightsAreKept) {
  const CalibrationProblem plain = Problem();
  double least = 1e300, most = -1e300;  // of A3, the last seen once
  for (const Configuration& configuration : plain.data().configurations) {
    least = std::min(least, configuration.q[2] / kDegree);
    most = std::max(most, configuration.q[2] / kDegree);
  }
  Robot robot = plain.robot();
  EffectSpec learnt{
      "learnt_deviation",
      "A3",
      {{"by", "q"}, {"driver", "A3"}, {"from", std::to_string(least)}, {"to", std::to_string(most)}, {"knots", "25"}},
      std::vector<double>(25, 0.0)};
  robot.effects.push_back(learnt);
  const CalibrationProblem kept = MakeCalibrationProblem(robot, plain.data(), plain.experiment());
  const CrossValidation found = test::CrossValidate(kept, EstimateJointly(kept), 1);
  const CrossValidation without = test::CrossValidate(plain, EstimateJointly(plain), 1);
  EXPECT_NEAR(found.unseen.distance_max / without.unseen.distance_max, 1.0, 1e-6);
  Experiment all = plain.experiment();
  all.estimate.effects.kind = Selection::Kind::kAll;
  const CalibrationProblem free = MakeCalibrationProblem(robot, plain.data(), all);
  EXPECT_EQ(free.parameters.EstimatedCoordinates().size(), kept.parameters.EstimatedCoordinates().size() + 25);
}

}  // namespace
}  // namespace sagitta::validation_test
