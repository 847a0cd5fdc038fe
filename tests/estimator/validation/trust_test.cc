// What the verdict compares and says: figures of the same kind before and after, one rule of what was predicted, the
// noise in an error.
#include "estimator/validation/trust.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/alignment/starting_values.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/inspection/row_lint.h"
#include "estimator/least_squares/refit.h"
#include "estimator/results/estimate_json.h"
#include "estimator/results/trust_json.h"
#include "tests/support/judged.h"
#include "tests/support/loaded_kr270.h"
#include "tests/support/predicted.h"

namespace sagitta::trust_test {
namespace {

using test::Kr270Design;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

using Change = std::function<void(Measurements*)>;

CalibrationProblem Problem(const Kr270Design& design, const Change& change = {}, const Experiment& experiment = {}) {
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 100 + design.seed, &data);
  if (change) change(&data);
  return test::Kr270ProblemOf(data, experiment);
}

Kr270Design Design(int configurations, std::uint64_t seed = 1) {
  Kr270Design design;
  design.configurations = configurations;
  design.seed = seed;
  return design;
}

Trust TrustOf(const CalibrationProblem& problem) {
  Estimate estimate = EstimateJointly(problem);
  return test::JudgeTrust(problem, 1, &estimate);
}

// Distances of every fold's points from base poses and markers refitted without them, the geometry nominal.
double RefittedNominalRms(const CalibrationProblem& problem, const ParameterSet& aligned) {
  ParameterSet start = aligned;
  for (int i = 0; i < start.num_coordinates(); ++i) {
    Coordinate& coordinate = start.coordinate(i);
    coordinate.free = coordinate.kind == CoordinateKind::kBase || coordinate.kind == CoordinateKind::kMarker;
  }
  const std::vector<int> fold_of = FoldsOf(problem, 1), rows = problem.CalibrationObservations();
  double squares = 0.0;
  for (int fold = 0; fold < kFolds; ++fold) {
    RefitOptions options;
    std::vector<int> left_out;
    for (const int i : rows) {
      const bool is_out = fold_of[problem.data().shots[problem.data().observations[i].shot].configuration] == fold;
      options.weights.push_back(is_out ? 0.0 : 1.0);
      if (is_out) left_out.push_back(i);
    }
    const Refit refit = RefitFrom(problem, start, options);
    EXPECT_TRUE(refit.converged);
    const Eigen::Matrix3Xd points = PredictPoints(problem, refit.parameters, left_out);
    squares += ResidualsOf(problem.data(), left_out, points).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(rows.size()));
}

TEST(NominalRobot, IsNotAlignedToThePointsThatItIsJudgedBy) {
  const CalibrationProblem problem = Problem(Design(24));
  const Estimate estimate = EstimateJointly(problem);
  const CrossValidation found = test::CrossValidate(problem, estimate, 1);
  ASSERT_EQ(found.nominal.points, found.unseen.points);
  EXPECT_NEAR(found.nominal.distance_rms / RefittedNominalRms(problem, estimate.aligned), 1.0, 0.01);
  EXPECT_GT(found.nominal.distance_rms, 1.03 * estimate.fit_before.distance_rms);
}

// Base and markers alone are estimated: before and after are one robot.
TEST(NominalRobot, IsAsGoodAsItself) {
  Experiment experiment;
  experiment.estimate.geometry.kind = Selection::Kind::kNone;
  for (const std::uint64_t seed : {1, 2, 3}) {
    Kr270Design design = Design(18, seed);
    Measurements data = test::DesignMeasurements(design);
    test::Kr270Truth truth;
    truth.errors.fill(0.0);
    test::MeasureKr270(truth, design.sigma, 40 + seed, &data);
    const Trust trust = TrustOf(test::Kr270ProblemOf(data, experiment));
    EXPECT_NEAR(trust.nominal.distance_rms / trust.Quoted().distance_rms, 1.0, 1e-3);
    EXPECT_THAT(trust.verdict.words, HasSubstr("the robot file was as good already"));
    EXPECT_TRUE(trust.verdict.trusted) << trust.verdict.words;
  }
}

// All errors are zero, and all are estimated: what 18 poses make worse is chance.
TEST(NominalRobot, ARobotFileThatIsRightIsNotCalledBetterByChance) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Kr270Design design = Design(18, seed);
    Measurements data = test::DesignMeasurements(design);
    test::Kr270Truth truth;
    truth.errors.fill(0.0);
    test::MeasureKr270(truth, design.sigma, 40 + seed, &data);
    const Trust trust = TrustOf(test::Kr270ProblemOf(data, {}));
    EXPECT_THAT(trust.verdict.words, Not(HasSubstr("times better than nominal"))) << seed;
    EXPECT_THAT(trust.verdict.words, HasSubstr("the robot file was as good already")) << seed;
    EXPECT_TRUE(trust.verdict.trusted) << trust.verdict.words;
  }
}

// Sums of squares of four poses in closed form: the same pose by pose, times a factor, is certain; one pose alone is
// not.
TEST(Gain, IsBeyondWhatConfigurationsScatterBy) {
  UnseenPoints before, after;
  before.squares = {4.0, 8.0, 6.0, 10.0};
  for (const double square : before.squares) after.squares.push_back(square / 9.0);
  before.rms = 3.0, after.rms = 1.0;
  EXPECT_EQ(CompareRms(before, after, 0.01, 0.05).compared, Compared::kBetter);
  EXPECT_EQ(CompareRms(after, before, 0.01, 0.05).compared, Compared::kWorse);
  after.squares = {4.0, 8.0, 6.0, 40.0};
  after.rms = 3.0 * std::sqrt(58.0 / 28.0);
  EXPECT_EQ(CompareRms(before, after, 0.01, 0.05).compared, Compared::kWithinUncertainty);
  after.squares = {8.0, 16.0, 12.0, 20.0};
  after.rms = 3.0 * std::sqrt(2.0);
  EXPECT_EQ(CompareRms(before, after, 0.01, 0.05).compared, Compared::kWorse);
  after.parameters_share = 0.5;  // all that it is worse by
  EXPECT_EQ(CompareRms(before, after, 0.01, 0.05).compared, Compared::kWithinUncertainty);
  after.rms = 3.1;
  EXPECT_EQ(CompareRms(before, after, 0.01, 0.05).compared, Compared::kAsGood);
}

// P3 is seen in one configuration alone: without it nothing says where P3 is.
TEST(CrossValidation, AMarkerOfOneConfigurationIsLeftOut) {
  const CalibrationProblem problem = Problem(Design(30), [](Measurements* data) {
    for (Observation& row : data->observations)
      row.excluded = row.marker == 2 && data->shots[row.shot].configuration != 4;
  });
  const Estimate estimate = EstimateJointly(problem);
  const CrossValidation found = test::CrossValidate(problem, estimate, 1);
  EXPECT_EQ(found.unpredictable.points, 1);
  EXPECT_THAT(found.unpredictable.markers, ElementsAre("P3"));
  EXPECT_THAT(found.unpredictable.stations, ElementsAre());
  EXPECT_EQ(found.unseen.points, 60);
  EXPECT_EQ(found.nominal.points, 60);
  EXPECT_LT(found.unseen.distance_max, 10 * Kr270Design().sigma);
  EXPECT_NEAR(found.unseen.Excess(), 1.0, 0.25);
  // The point after the one that is left out (P1 of configuration 5), from a refit without its fold.
  const std::vector<int> fold_of = FoldsOf(problem, 1);
  ParameterSet start = estimate.parameters;
  for (const int i : start.Match("marker/P3")) start.coordinate(i).held = true;
  RefitOptions options;
  for (const int i : problem.CalibrationObservations()) {
    const int configuration = problem.data().shots[problem.data().observations[i].shot].configuration;
    options.weights.push_back(fold_of[configuration] == fold_of[5] ? 0.0 : 1.0);
  }
  const Refit refit = RefitFrom(problem, start, options);
  ASSERT_TRUE(refit.converged);
  const double distance = ResidualsOf(problem.data(), {15}, PredictPoints(problem, refit.parameters, {15})).norm();
  EXPECT_NEAR(found.unseen.distances[10], distance, 0.02 * Kr270Design().sigma);
}

TEST(CrossValidation, AStationOfOneConfigurationIsLeftOut) {
  const CalibrationProblem problem = Problem(Design(30), [](Measurements* data) {
    for (Shot& shot : data->shots) shot.station = shot.configuration == 7 ? 1 : 0;
    test::MeasureKr270(test::Kr270Truth(), Kr270Design().sigma, 8, data);
  });
  const Estimate estimate = EstimateJointly(problem);
  const CrossValidation found = test::CrossValidate(problem, estimate, 1);
  EXPECT_EQ(found.unpredictable.points, 3);
  EXPECT_THAT(found.unpredictable.stations, ElementsAre("S2"));
  EXPECT_EQ(found.unseen.points, 87);
  EXPECT_LT(found.unseen.distance_max, 10 * Kr270Design().sigma);
  EXPECT_NEAR(found.unseen.Excess(), 1.0, 0.25);
}

// Six poses for some 30 unknowns of an arm that is made to 20 um: what they leave unknown is far more.
TEST(Verdict, FewPosesThatMakeTheRobotWorseAreNotTrusted) {
  Measurements data = test::DesignMeasurements(Design(7));
  test::Kr270Truth exact;
  for (double& error : exact.errors) error *= 0.02;
  test::MeasureKr270(exact, Kr270Design().sigma, 8, &data);
  const Trust trust = TrustOf(test::Kr270ProblemOf(data, Experiment()));
  ASSERT_GT(trust.cross_validation.unseen.points, 0);
  EXPECT_LT(trust.gain.ratio, 0.95);
  EXPECT_FALSE(trust.verdict.trusted) << trust.verdict.words;
}

// Every pose has its own station: nothing is said of what is not seen, and why.
TEST(CrossValidation, WhereNoPointIsPredictedThereAreNoFigures) {
  const CalibrationProblem problem = Problem(Design(20), [](Measurements* data) {
    data->stations.clear();
    for (size_t s = 0; s < data->shots.size(); ++s) {
      data->shots[s].station = data->shots[s].configuration;
      data->stations.push_back("T" + std::to_string(s));
    }
  });
  Estimate estimate = EstimateJointly(problem);
  const Trust trust = test::JudgeTrust(problem, 1, &estimate);
  EXPECT_EQ(trust.cross_validation.unseen.points, 0);
  EXPECT_EQ(trust.cross_validation.unpredictable.points, 60);
  EXPECT_THAT(trust.verdict.reasons, Contains(HasSubstr("no other poses predict it")));
  nlohmann::ordered_json json = EstimateToJson(problem, estimate, {});
  AddTrustTo(estimate, trust, &json);
  EXPECT_TRUE(json["cross_validation"]["distance_rms_mm"].is_null());
  EXPECT_TRUE(json["cross_validation"]["prediction_p_value"].is_null());
}

// Where no row of a station is at hand there is nothing to register, and nothing to divide by.
TEST(StartingValues, AStationWithoutRowsStaysWhereItIs) {
  const CalibrationProblem problem = Problem(Design(30));
  std::vector<int> of_first;
  for (const int i : problem.CalibrationObservations()) {
    if (problem.data().shots[problem.data().observations[i].shot].station == 0) of_first.push_back(i);
  }
  ParameterSet parameters = problem.parameters;
  const Vector3<double> there(1.0, 2.0, 3.0);
  parameters.SetBaseInStation(1, {Matrix3<double>::Identity(), there});
  EXPECT_LT(FindStartingValues(problem, of_first, &parameters), 1e-2);
  EXPECT_EQ(parameters.BaseInStation(1).translation, there);
}

// Held-out points that are off by `size` (m) more.
CalibrationProblem OffWhereHeldOut(double size) {
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  CalibrationProblem problem = Problem(Design(60), {}, experiment);
  for (const int i : problem.ValidationObservations())
    problem.mutable_data()->observations[i].point_in_station.z() += (i % 2 == 0 ? 1.0 : -1.0) * size;
  return problem;
}

TEST(Trust, WhatTheIntervalsCarryIsSaidAndNoReason) {
  const Trust little = TrustOf(OffWhereHeldOut(1.5e-4));
  ASSERT_LT(little.holdout.p_value, 0.01);
  ASSERT_LT(little.holdout.Excess(), std::sqrt(2.0));
  EXPECT_TRUE(little.verdict.trusted) << little.verdict.words;
  EXPECT_THAT(little.verdict.words, HasSubstr("times smaller"));
  EXPECT_GE(little.model_error, little.holdout.Excess() * (1 - 1e-9));
  const Trust much = TrustOf(OffWhereHeldOut(4e-4));
  ASSERT_GT(much.holdout.Excess(), std::sqrt(2.0));
  EXPECT_FALSE(much.verdict.trusted) << much.verdict.words;
  EXPECT_THAT(much.verdict.words, HasSubstr("the errors on the points held out are"));
}

// Ten shots of each of 15 poses, off by one error per pose: residuals do not show what new poses will be off by.
TEST(Trust, ACrossValidationIsJudgedByTheSameRule) {
  const CalibrationProblem problem = Problem(Design(15), [](Measurements* data) {
    std::vector<Shot> shots;
    std::vector<Observation> rows;
    NormalNumbers normal(5);
    for (const Shot& shot : data->shots) {
      const Vector3<double> off = 6e-4 * test::RandomVector(normal);
      for (int repeat = 0; repeat < 10; ++repeat) {
        Shot again = shot;
        again.repeat = std::to_string(repeat);
        again.observations.clear();
        for (const int i : shot.observations) {
          Observation row = data->observations[i];
          row.shot = static_cast<int>(shots.size());
          row.point_in_station = test::ExactPoint(test::Kr270Truth(), *data, data->observations[i]) + off +
                                 1e-4 * test::RandomVector(normal);
          again.observations.push_back(static_cast<int>(rows.size()));
          rows.push_back(row);
        }
        shots.push_back(again);
      }
    }
    data->shots = shots;
    data->observations = rows;
  });
  const Trust trust = TrustOf(problem);
  ASSERT_EQ(trust.holdout.points, 0);
  ASSERT_GT(trust.cross_validation.unseen.Excess(), std::sqrt(2.0));
  EXPECT_FALSE(trust.verdict.trusted);
  EXPECT_THAT(trust.verdict.words, HasSubstr("the errors in the cross-validation are"));
}

TEST(Trust, ResidualsThatRefuteTheStatedNoiseAreSaid) {
  const CalibrationProblem problem = Problem(Design(30), [](Measurements* data) {
    for (Observation& row : data->observations) row.sigma /= 14.0;
  });
  const std::string words = TrustOf(problem).verdict.words;
  EXPECT_THAT(words, ::testing::ContainsRegex("The residuals are 1[345](\\.[0-9])? times what the stated standard"));
  EXPECT_THAT(words, HasSubstr("'sagitta diagnose' distinguishes"));
  EXPECT_THAT(words, HasSubstr("judged with the scatter of the residuals"));
  EXPECT_THAT(TrustOf(Problem(Design(30))).verdict.words, Not(HasSubstr("The residuals are")));
}

// q = 5, n = 4: r = 3 where nu says so; with nu = 8 the variance of q^2 is 25^2 / 4.
TEST(NoiseShare, IsWhatTheReadingsAreOffBy) {
  Estimate estimate;
  estimate.sigma.stated = true;
  estimate.noise = NoiseRoots(6, 4.0 / std::sqrt(3.0) * Matrix3<double>::Identity());
  UnseenPoints unseen;
  unseen.points = 6;
  unseen.distance_rms = 5.0;
  unseen.freedom = 20000.0;
  NoiseShare share = ShareOfNoise(estimate, {0, 1, 2, 3, 4, 5}, unseen);
  EXPECT_NEAR(share.noise, 4.0, 1e-12);
  EXPECT_NEAR(share.rest, 3.0, 1e-12);
  EXPECT_FALSE(share.rest_is_bound);
  EXPECT_NEAR(share.rms_known_to, 0.0098, 1e-4);
  EXPECT_NEAR(share.beyond_noise, 3.0, 1e-12);
  unseen.parameters_share = 0.2;  // they add a quarter of the noise's square
  EXPECT_NEAR(ShareOfNoise(estimate, {0, 1, 2, 3, 4, 5}, unseen).beyond_noise, std::sqrt(5.0), 1e-12);
  unseen.parameters_share = 0.0;
  unseen.freedom = 8.0;
  share = ShareOfNoise(estimate, {0, 1, 2, 3, 4, 5}, unseen);
  EXPECT_TRUE(share.rest_is_bound);
  EXPECT_NEAR(share.rest, std::sqrt(9.0 + 1.644854 * 12.5), 1e-5);
  estimate.noise = NoiseRoots(6, Matrix3<double>::Identity());  // 1.7 of 5: no considerable part
  EXPECT_EQ(share.beyond_noise, 0.0);                           // 9 is within 1.96 * 12.5
  unseen.freedom = 20000.0;
  share = ShareOfNoise(estimate, {0, 1, 2, 3, 4, 5}, unseen);
  EXPECT_EQ(share.noise, 0.0);
  EXPECT_NEAR(share.beyond_noise, std::sqrt(22.0), 1e-12);
  estimate.sigma.stated = false;  // what the model lacks is in the noise
  EXPECT_EQ(ShareOfNoise(estimate, {0, 1, 2, 3, 4, 5}, unseen).beyond_noise, 0.0);
}

TEST(NoiseShare, OfUnstatedNoiseTheRobotHasAnUnknownPart) {
  const CalibrationProblem problem = Problem(Design(30), [](Measurements* data) {
    for (Observation& row : data->observations) row.sigma.setZero();
  });
  const std::string words = TrustOf(problem).verdict.words;
  EXPECT_THAT(words, HasSubstr("of what the model lacks alike, is 0.1"));
  EXPECT_THAT(words, Not(HasSubstr("left for the robot")));
}

// Points and rotations weighed by the spread of their residuals know no more; components of the joints do.
TEST(NoiseShare, TheSpreadOfResidualsIsNoInstrument) {
  Estimate estimate;
  estimate.noise = NoiseRoots(6, Matrix3<double>::Identity());
  UnseenPoints unseen;
  unseen.points = 6;
  unseen.distance_rms = 2.0;
  unseen.freedom = 200.0;
  const std::vector<int> points = {0, 1, 2, 3, 4, 5};
  EXPECT_TRUE(ShareOfNoise(estimate, points, unseen).of_residuals);
  estimate.sigma.stated = true;
  EXPECT_FALSE(ShareOfNoise(estimate, points, unseen).of_residuals);
  estimate.noise_report.components.resize(2);  // points, rotations: weights that count as stated
  estimate.noise_report.components[1].of_rotations = true;
  EXPECT_TRUE(ShareOfNoise(estimate, points, unseen).of_residuals);
  estimate.noise_report.components[1].of_rotations = false;
  estimate.noise_report.components[1].joints = {0, 1};
  EXPECT_FALSE(ShareOfNoise(estimate, points, unseen).of_residuals);
}

TEST(NoiseShare, IsInTheVerdict) {
  const Trust trust = TrustOf(Problem(Design(30)));
  EXPECT_THAT(trust.verdict.words, HasSubstr("the noise of the readings is 0.173 mm"));  // 0.1 sqrt(3)
  EXPECT_THAT(trust.verdict.words, HasSubstr("what is left for the robot"));
}

// One marker, 13 to 22 poses: of 39 equations and 27 unknowns a robust fit leaves most residuals at nothing.
CalibrationProblem FewPoses(int poses, std::uint64_t seed, const Change& change = {}) {
  Kr270Design design = Design(poses, seed);
  design.stations = 1;
  return Problem(design, [&](Measurements* data) {
    test::KeepFirstMarker(data);
    if (change) change(data);
  });
}

TEST(Suspects, FewPosesAreNotAccusedOfInterpolatingOthers) {
  for (const int poses : {13, 14, 16, 18, 22}) {
    int accused = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const CalibrationProblem problem = FewPoses(poses, seed);
      accused += FindSuspects(problem, EstimateJointly(problem)).empty() ? 0 : 1;
    }
    EXPECT_EQ(accused, 0) << poses << " poses";
  }
}

TEST(Suspects, GrossRowsAreFoundFromThirtyPosesOn) {
  for (const int poses : {30, 45}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const CalibrationProblem problem = FewPoses(poses, seed, [](Measurements* data) {
        data->observations[5].point_in_station.x() += 5e-3;
        data->observations[20].point_in_station.z() -= 20e-3;
      });
      std::vector<std::string> rows;
      for (const Suspect& suspect : FindSuspects(problem, EstimateJointly(problem))) rows.push_back(suspect.row);
      EXPECT_THAT(rows, ElementsAre("simulated.csv:17", "simulated.csv:62")) << poses << " " << seed;
    }
  }
}

TEST(RowLint, TheScaleIsThatOfRowsTheFitDoesNotPassThrough) {
  const std::vector<double> distances = {5.0, 0.0, 3.0, 0.0, 4.0};
  EXPECT_EQ(TypicalDistance(distances, 0), 3.0);
  EXPECT_EQ(TypicalDistance(distances, 6), 4.0);  // two rows of three equations
  EXPECT_TRUE(std::isinf(TypicalDistance(distances, 15)));
}

// Sums of squared errors of many campaigns: parameters drawn of C, joints' deviations once per arrival, readings of
// their noise; mean tr V, variance 2 tr V^2.
TEST(Prediction, TracesAreThoseOfDrawnErrors) {
  Experiment experiment;
  experiment.repeatability.angle.common = 60e-6;
  CalibrationProblem problem = Problem(Design(14), {}, experiment);
  const Estimate estimate = EstimateJointly(problem);
  problem.parameters.CopyByName(estimate.parameters);
  std::vector<int> rows;
  for (int i = 0; i < 12; ++i) rows.push_back(i);
  const NoiseRoots instrument(rows.size(), 5e-5 * Matrix3<double>::Identity());
  PredictedSquares traces;
  PredictionCovariances(problem, test::UncertaintyOf(estimate), rows, 1.0, instrument, &traces);
  const Eigen::MatrixXd root = estimate.covariance.llt().matrixL();
  NormalNumbers normal(3);
  constexpr int kDraws = 4000;
  double sum = 0.0, squares = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::VectorXd moved(root.cols()), step = Eigen::VectorXd::Zero(estimate.parameters.num_coordinates());
    for (double& number : moved) number = normal();
    moved = (root * moved).eval();
    for (size_t c = 0; c < estimate.estimated.size(); ++c) step[estimate.estimated[c]] = moved[static_cast<long>(c)];
    CalibrationProblem drawn = problem;
    for (int c = 0; c < 4; ++c) {
      for (double& q : drawn.mutable_data()->configurations[static_cast<size_t>(c)].q) q += 60e-6 * normal();
    }
    drawn.RenewJoints();
    ParameterSet parameters = estimate.parameters;
    parameters.Plus(step);
    Eigen::Matrix3Xd errors =
        PredictPoints(drawn, parameters, rows) - PredictPoints(problem, estimate.parameters, rows);
    for (double& error : errors.reshaped()) error += 5e-5 * normal();
    const double square = errors.squaredNorm();
    sum += square;
    squares += square * square;
  }
  const double mean = sum / kDraws, variance = squares / kDraws - mean * mean;
  const double deviation = std::sqrt(variance / kDraws);
  EXPECT_NEAR(traces.trace, mean, 4.0 * deviation);
  EXPECT_NEAR(2.0 * traces.trace_of_square / variance, 1.0, 0.2);
}

// A robot whose deflections are known fits its loaded readings, whatever the arm without load does.
TEST(AlignedMisfit, IsThatOfTheArmUnderItsLoads) {
  test::LoadedTruth truth;
  truth.errors.fill(0.0);
  const test::LoadedDesign design;
  Measurements data = test::LoadedRows(design, truth);
  test::Measure(test::ExactPoints(truth, data), 0.0, 1, &data);
  test::LoadedSetup setup = test::SetupFor(truth);
  const auto misfit = [&] {
    const CalibrationProblem problem = MakeCalibrationProblem(setup.robot, data, setup.experiment);
    return AlignedMisfit(problem, SampleOfRows(problem));
  };
  EXPECT_GT(misfit(), 5e-4);
  for (int j = 0; j < 6; ++j) setup.robot.compliances.push_back({j, {{0.0, truth.k[static_cast<size_t>(j)]}}, false});
  EXPECT_LT(misfit(), 5e-6);
}

}  // namespace
}  // namespace sagitta::trust_test
