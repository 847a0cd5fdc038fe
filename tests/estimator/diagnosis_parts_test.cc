// Parts of the diagnosis alone: what counts as an outlier, the rule of choosing, decoys beside a joint that stands
// still, searches on several threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "estimator/diagnosis/decoys.h"
#include "estimator/diagnosis/noise_book.h"
#include "estimator/diagnosis/noise_check.h"
#include "estimator/diagnosis/screening.h"
#include "estimator/diagnosis/selection.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/parallel.h"
#include "problems/loads.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta {
namespace {

constexpr double kSigma = 2e-5;         // m
constexpr double kSignificance = 1e-3;  // of outliers

// 40 configurations, three markers on the flange, a quarter held out; joint 6 stands still where asked.
DiagnosedModel Healthy(std::uint64_t seed, bool parked = false) {
  test::Kr270Design design;
  design.configurations = 40;
  design.stations = 1;
  design.sigma = kSigma;
  design.seed = seed;
  Measurements data = test::DesignMeasurements(design);
  for (Configuration& configuration : data.configurations) {
    if (parked) configuration.q[5] = 0.5;
  }
  test::MeasureKr270(test::Kr270Truth(), kSigma, 300 + seed, &data);
  Robot robot;
  robot.chain = test::Kr270Chain();
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.25;
  return FitFully(MakeCalibrationProblem(robot, data, experiment), JointOptions());
}

// Rows need not be in the order of time.
TEST(Conditions, TimeCountsFromTheFirstRowOfAStation) {
  const CalibrationProblem problem = *Healthy(1).problem;
  Measurements data = problem.data;
  for (size_t s = 0; s < data.shots.size(); ++s) {
    data.shots[s].has_time = true;
    data.shots[s].time = 100.0 - 5.0 * static_cast<double>(s);
  }
  const std::vector<ShotInput> inputs = MakeShotInputs(problem.model, data, problem.experiment);
  for (size_t s = 0; s < inputs.size(); ++s) EXPECT_EQ(inputs[s].conditions.time, -5.0 * static_cast<double>(s));
}

// A shot counts at the mean of its rows, the clock of the station starts with its first row.
TEST(Conditions, TheFirstRowIsNotItsShot) {
  const CalibrationProblem problem = *Healthy(1).problem;
  Measurements data = problem.data;
  data.files = {{"m.csv", "", {"time_s"}, {}}};
  for (size_t i = 0; i < data.observations.size(); ++i) {
    data.files[0].rows.push_back({static_cast<int>(i) + 2, {std::to_string(1000 + 30 * i)}});
    data.observations[i].file = 0;
    data.observations[i].row = static_cast<int>(i);
  }
  for (Shot& shot : data.shots) {
    shot.has_time = true;
    for (const int i : shot.observations)
      shot.time += (1000.0 + 30.0 * i) / static_cast<double>(shot.observations.size());
  }
  const std::vector<ShotInput> inputs = MakeShotInputs(problem.model, data, problem.experiment);
  for (size_t s = 0; s < inputs.size(); ++s) {
    EXPECT_NEAR(inputs[s].conditions.time, data.shots[s].time - 1000.0, 1e-9);
  }
  EXPECT_GT(inputs[0].conditions.time, 1.0);
}

// What an effect says of a joint that slides is defined or it is not asked; what never changes drives nothing.
TEST(Candidates, WhatCannotBeTestedIsListedWithItsReason) {
  CalibrationProblem problem = *Healthy(1).problem;
  problem.robot.chain.joints[2].type = JointType::kPrismatic;
  for (ShotInput& shot : problem.shot_inputs) {
    shot.conditions.has_time = true;
    shot.conditions.time = 7.0;
  }
  const CandidateList list = ListCandidates(problem, problem.parameters);
  const auto is_candidate = [&](const std::string& effect, const std::string& target) {
    return std::any_of(list.candidates.begin(), list.candidates.end(), [&](const Candidate& candidate) {
      return candidate.spec.effect == effect && candidate.spec.target == target;
    });
  };
  const auto need_of = [&](const std::string& effect, const std::string& target) -> std::string {
    for (const NotTestable& entry : list.not_testable) {
      if (entry.effect == effect && entry.target == target) return entry.needs;
    }
    return "";
  };
  EXPECT_TRUE(is_candidate("joint_harmonic", "A2"));
  EXPECT_TRUE(is_candidate("encoder_gain", "A3"));
  EXPECT_FALSE(is_candidate("joint_harmonic", "A3"));
  EXPECT_EQ(need_of("joint_harmonic", "A3"), "a revolute joint");
  EXPECT_FALSE(is_candidate("joint_slip", "A1"));
  EXPECT_EQ(need_of("joint_slip", "A1"), "time_s that varies");
  EXPECT_EQ(need_of("thermal_growth", "robot"), "temperature_degC");
  EXPECT_EQ(need_of("link_gravity", "A2"), "joint compliances above 0 (loaded rows)");
}

// What weighs cannot be asked where nobody knows which way is down; stated in the base frame it is known.
TEST(Candidates, WeightsNeedTheDirectionOfGravity) {
  CalibrationProblem problem = *Healthy(1).problem;
  const auto of_sag = [&](const CandidateList& list) {
    return std::count_if(list.candidates.begin(), list.candidates.end(),
                         [](const Candidate& candidate) { return candidate.spec.effect == "self_weight_sag"; });
  };
  const CandidateList levelled = ListCandidates(problem, problem.parameters);
  EXPECT_GT(of_sag(levelled), 0);
  problem.experiment.stations[problem.data.stations[0]].levelled = false;
  const CandidateList unlevelled = ListCandidates(problem, problem.parameters);
  EXPECT_EQ(of_sag(unlevelled), 0);
  EXPECT_EQ(unlevelled.candidates.size(), levelled.candidates.size() - of_sag(levelled));
  const bool says_why =
      std::any_of(unlevelled.not_testable.begin(), unlevelled.not_testable.end(), [](const NotTestable& entry) {
        return entry.effect == "self_weight_sag" && entry.needs.find("gravity") != std::string::npos;
      });
  EXPECT_TRUE(says_why);
  problem.experiment.gravity_in_base = true;
  EXPECT_EQ(of_sag(ListCandidates(problem, problem.parameters)), of_sag(levelled));
}

// Repeats that show half of the noise: three leave it open, three hundred do not.
TEST(NoiseBook, FewRepeatsLeaveSigmaOpen) {
  for (const int repeats : {3, 300}) {
    CalibrationProblem problem = *Healthy(1).problem;
    problem.experiment.noise.from = NoiseSpec::From::kRepeats;
    problem.repeat_scatter = RepeatScatter{Vector3<double>::Constant(0.5 * kSigma), repeats};
    problem.resolved_noise.assign(problem.data.observations.size(), 0.5 * kSigma * Matrix3<double>::Identity());
    DiagnosedModel model = FitFully(problem, JointOptions());
    NoiseBook book(problem, 0.01, JointOptions());
    book.Prepare(&model);
    EXPECT_NEAR(model.estimate.chi2 / model.estimate.dof, 1.0, 0.1);
    EXPECT_EQ(book.finding().scale_differs, repeats == 300);
    book.Close(model, false, 0.01);
    EXPECT_EQ(book.finding().is_finding, repeats == 300);
    if (repeats == 3) {
      EXPECT_GT(book.LackOfFit(model), 0.001);
      EXPECT_NEAR(book.finding().taken_of_repeats, 2.0, 0.15);
      // chi2_9 has its 2.5 and 97.5 % at 2.70 and 19.02: 2 sqrt(2.70 / 9) and 2 sqrt(19.02 / 9).
      EXPECT_NEAR(book.finding().low, 1.095, 0.1);
      EXPECT_NEAR(book.finding().high, 2.907, 0.15);
    }
  }
}

// A stated sigma that is a fifth too small shows in 200 degrees of freedom, but hardly in the 87 that the markers'
// rigidity has: it is the sigma all the same, for what is left scatters no more than the rigidity says.
TEST(NoiseBook, SigmaThatIsALittleTooSmallIsNoStructure) {
  const CalibrationProblem problem = WithScaledSigmas(*Healthy(1).problem, 1.0 / 1.2);
  DiagnosedModel model = FitFully(problem, JointOptions());
  NoiseBook book(problem, 0.01, JointOptions());
  book.Prepare(&model);
  ASSERT_FALSE(book.finding().scale_differs);
  EXPECT_LT(book.LackOfFit(model), 0.0015);
  EXPECT_TRUE(book.Close(model, false, 0.0015));
  EXPECT_TRUE(book.finding().scale_differs);
  EXPECT_LT(book.finding().low, 1.2);
  EXPECT_GT(book.finding().high, 1.2);
}

// Markers that move as a whole, by twice the noise, are no noise of the instrument.
TEST(NoiseBook, BodiesThatMoveAreStructure) {
  CalibrationProblem problem = *Healthy(1).problem;
  for (size_t s = 0; s < problem.data.shots.size(); ++s) {
    for (const int i : problem.data.shots[s].observations) {
      problem.data.observations[i].point_in_station.z() += (s % 2 ? 2.0 : -2.0) * kSigma;
    }
  }
  DiagnosedModel model = FitFully(problem, JointOptions());
  NoiseBook book(problem, 0.01, JointOptions());
  book.Prepare(&model);
  EXPECT_LT(book.LackOfFit(model), 0.0015);
  EXPECT_FALSE(book.Close(model, false, 0.0015));
  EXPECT_FALSE(book.finding().is_finding);
}

CalibrationProblem WithStatedRepeatability(CalibrationProblem problem, double sigma) {
  problem.experiment.repeatability.angle.common = sigma;
  problem.latent = MakeLatentModel(problem.robot.chain, problem.data, problem.experiment);
  return problem;
}

// The joints do not deviate here. A microradian more or less is nothing; 60 would hide most effects.
TEST(NoiseBook, RepeatabilityThatRowsContradictIsNotTaken) {
  for (const double stated : {1e-6, 60e-6}) {
    const CalibrationProblem problem = WithStatedRepeatability(*Healthy(1).problem, stated);
    DiagnosedModel model = FitFully(problem, JointOptions());
    NoiseBook book(problem, 0.01, JointOptions());
    book.Prepare(&model);
    EXPECT_EQ(book.repeatability_is_stated(), stated < 2e-6);
    EXPECT_EQ(book.finding().repeatability_is_overstated, stated > 2e-6);
    EXPECT_EQ(model.problem->latent.empty(), stated > 2e-6);
  }
}

// Moves every marker as if the joint stood this many urad beyond its reading, a function of the angles.
void Deviate(const DiagnosedModel& healthy, int joint, const std::function<double(const Eigen::VectorXd&)>& urad,
             CalibrationProblem* problem) {
  const Eigen::MatrixXd per_urad = JointDeviationColumns(*problem, healthy.estimate.parameters);
  const std::vector<int> rows = problem->CalibrationObservations();
  for (size_t k = 0; k < rows.size(); ++k) {
    Observation& observation = problem->data.observations[rows[k]];
    const double size = urad(problem->data.ConfigurationOf(observation).q);
    observation.point_in_station += kSigma * size * per_urad.col(joint).segment<3>(3 * k);
  }
}

// Joint 3 deviates by the product of two other joints' angles: as large as any repeatability, but no chance.
TEST(NoiseBook, ACauseOutsideTheCatalogueIsNoRepeatability) {
  const DiagnosedModel healthy = Healthy(1);
  CalibrationProblem problem = *healthy.problem;
  Deviate(
      healthy, 2, [](const Eigen::VectorXd& q) { return 200.0 * q[1] * q[4]; }, &problem);
  DiagnosedModel model = FitFully(problem, JointOptions());
  EXPECT_GT(FitRepeatability(problem, model.estimate.parameters, false).gain, 100.0);
  NoiseBook book(problem, 0.01, JointOptions());
  book.AddRepeatability(DecoyBench(model).Best().penalised, &model);
  EXPECT_EQ(book.finding().repeatability, 0.0);
  EXPECT_TRUE(model.problem->latent.empty());
}

// A gap far beyond what repeats leave open is none of the noise's.
TEST(NoiseBook, RepeatsBoundTheNoise) {
  CalibrationProblem problem = *Healthy(1).problem;
  problem.experiment.noise.from = NoiseSpec::From::kRepeats;
  problem.repeat_scatter = RepeatScatter{Vector3<double>::Constant(kSigma), 100};
  problem.resolved_noise.assign(problem.data.observations.size(), kSigma * Matrix3<double>::Identity());
  for (size_t s = 0; s < problem.data.shots.size(); ++s) {  // the shot as a whole: markers stay rigid
    for (const int i : problem.data.shots[s].observations) {
      problem.data.observations[i].point_in_station.z() += (s % 2 ? 10.0 : -10.0) * kSigma;
    }
  }
  DiagnosedModel model = FitFully(problem, JointOptions());
  NoiseBook book(problem, 0.01, JointOptions());
  book.Prepare(&model);
  // 300 degrees of freedom: at most 1.12 of the sigma that the repeats show, sqrt(300 / chi2_300(0.005)).
  EXPECT_GT(model.estimate.chi2 / model.estimate.dof, 10.0);
  EXPECT_LT(book.LackOfFit(model), 1e-6);
}

std::vector<int> Outliers(const DiagnosedModel& model, bool held_out) {
  const CalibrationProblem& problem = *model.problem;
  std::vector<int> found = FindOutliers(problem, model.estimate.parameters,
                                        held_out ? problem.ValidationObservations() : problem.CalibrationObservations(),
                                        kSignificance, held_out, 0);
  std::sort(found.begin(), found.end());
  return found;
}

// 40 sigma: far beyond the limit of about 5.
void Spoil(DiagnosedModel* model, const std::vector<int>& observations) {
  CalibrationProblem problem = *model->problem;
  double sign = 1.0;
  for (const int i : observations) {
    problem.data.observations[i].point_in_station += sign * Vector3<double>(40 * kSigma, 0.0, 0.0);
    sign = -sign;
  }
  model->problem = std::make_shared<CalibrationProblem>(problem);
}

TEST(DiagnosisOutliers, NoneInHealthyRows) {
  const DiagnosedModel model = Healthy(1);
  EXPECT_TRUE(Outliers(model, false).empty());
  EXPECT_TRUE(Outliers(model, true).empty());
}

TEST(DiagnosisOutliers, TwoInOneShotDoNotHideEachOther) {
  DiagnosedModel model = Healthy(1);
  const std::vector<int>& shot =
      model.problem->data.shots[model.problem->data.observations[model.problem->CalibrationObservations()[0]].shot]
          .observations;
  ASSERT_EQ(shot.size(), 3u);
  const std::vector<int> spoilt = {shot[0], shot[2]};
  Spoil(&model, spoilt);
  EXPECT_EQ(Outliers(model, false), spoilt);
}

TEST(DiagnosisOutliers, HeldOutRowsAreJudgedByTheirBodyAlone) {
  DiagnosedModel model = Healthy(1);
  const std::vector<int> held_out = model.problem->ValidationObservations();
  Spoil(&model, {held_out[4]});
  EXPECT_EQ(Outliers(model, true), std::vector<int>{held_out[4]});
  // All three markers of a shot off alike: the model's error, not theirs.
  DiagnosedModel moved = Healthy(1);
  CalibrationProblem problem = *moved.problem;
  const Shot& shot = problem.data.shots[problem.data.observations[held_out[0]].shot];
  for (const int i : shot.observations) problem.data.observations[i].point_in_station.x() += 40 * kSigma;
  moved.problem = std::make_shared<CalibrationProblem>(problem);
  EXPECT_TRUE(Outliers(moved, true).empty());
}

// Markers of one shot on two bodies: that one moves against the other is no noise. Two markers keep one distance, so of
// 30 fitted configurations 30 - 1 degrees of freedom are left.
TEST(DiagnosisNoise, BodiesAreRigidEachForItself) {
  DiagnosedModel model = Healthy(2);
  CalibrationProblem problem = *model.problem;
  for (Observation& observation : problem.data.observations) {
    if (observation.marker == 2) observation.point_in_station.y() += 3e-3 * std::sin(observation.shot);
  }
  const auto together = InstrumentNoiseScale(problem, model.estimate.parameters, 0.01);
  ASSERT_TRUE(together);
  EXPECT_GT(together->scale, 10.0);
  problem.marker_frames[2] = problem.marker_frames[0] - 1;  // as if on the link before
  const auto apart = InstrumentNoiseScale(problem, model.estimate.parameters, 0.01);
  ASSERT_TRUE(apart);
  EXPECT_EQ(apart->dof, 29);
  EXPECT_LT(apart->low, 1.0);
  EXPECT_GT(apart->high, 1.0);
}

// Where markers are no rigid body the scatter of 100 degrees of freedom tells the scale, and with structure in it
// bounds it. Quantiles of chi-square, 2.5 % and 97.5 %, 100 degrees of freedom: 74.222 and 129.561.
TEST(DiagnosisNoise, StructureLeavesAnUpperBoundOfTheScale) {
  const CalibrationProblem problem = *Healthy(1).problem;
  DiagnosedModel final;
  final.estimate.chi2 = 400.0;
  final.estimate.dof = 100;
  NoiseBook told(problem, 0.01, JointOptions());
  EXPECT_TRUE(std::isnan(told.finding().high));
  EXPECT_TRUE(told.Close(final, false, 0.001));
  EXPECT_NEAR(told.finding().scale, 2.0, 1e-12);
  EXPECT_NEAR(told.finding().low, std::sqrt(400.0 / 129.561), 1e-5);
  EXPECT_NEAR(told.finding().high, std::sqrt(400.0 / 74.222), 1e-5);
  NoiseBook bounded(problem, 0.01, JointOptions());
  EXPECT_FALSE(bounded.Close(final, true, 0.001));
  EXPECT_EQ(bounded.finding().scale, 1.0);
  EXPECT_EQ(bounded.finding().low, 0.0);
  EXPECT_NEAR(bounded.finding().high, std::sqrt(400.0 / 74.222), 1e-5);
  EXPECT_TRUE(bounded.finding().is_bound);
  EXPECT_FALSE(bounded.finding().is_finding);
}

ChosenStep Step(const std::string& effect, const std::string& target, int parameters, double reduction,
                double penalised, int place) {
  ChosenStep step;
  step.candidate.spec = {effect, target, {}, {}};
  step.candidate.place = place;
  step.parameters = parameters;
  step.reduction = reduction;
  step.penalised = penalised;
  return step;
}

TEST(DiagnosisRule, TiesGoToTheFewestParametersThenTheCatalogue) {
  const std::vector<ChosenStep> steps = {Step("axis_wobble", "A2", 4, 130, 102, 1),
                                         Step("encoder_gain", "A2", 1, 104, 97, 2),
                                         Step("backlash", "A3", 1, 104, 97.5, 3), Step("payload", "V1", 1, 90, 83, 0)};
  EXPECT_EQ(PickByRule(steps, 6.0).candidate.spec.effect, "encoder_gain");
  EXPECT_EQ(PickByRule(steps, 1.0).candidate.spec.effect, "axis_wobble");
}

// What only an absurd size explains loses a tie, and wins where it fits better than any other.
TEST(DiagnosisRule, AnOversizedEffectLosesTies) {
  std::vector<ChosenStep> steps = {Step("encoder_gain", "A6", 1, 110, 103, 0),
                                   Step("joint_coupling", "A5", 1, 108, 101, 1),
                                   Step("axis_wobble", "A6", 2, 90, 76, 2)};
  steps[0].candidate.oversized = true;
  EXPECT_EQ(PickByRule(steps, 6.0).candidate.spec.effect, "joint_coupling");
  EXPECT_EQ(PickByRule(steps, 1.0).candidate.spec.effect, "encoder_gain");
}

// Of one effect the better fit, not the target of which the data tell fewer parameters.
TEST(DiagnosisRule, TargetsOfOneEffectAreChosenByTheirFit) {
  const std::vector<ChosenStep> steps = {Step("link_gravity", "A3", 3, 91.8, 70.8, 1),
                                         Step("link_gravity", "A6", 4, 98.2, 70.2, 1)};
  EXPECT_EQ(PickByRule(steps, 6.0).candidate.spec.target, "A6");
}

// Rounding does not decide which of two that no data tell apart is named.
TEST(DiagnosisRule, OfTwinsTheFirstInTheList) {
  const std::vector<ChosenStep> steps = {Step("station_scale", "S2", 1, 50.0004, 43.0004, 2),
                                         Step("station_scale", "S1", 1, 50, 43, 1),
                                         Step("station_scale", "S3", 1, 49, 42, 0)};
  EXPECT_EQ(PickByRule(steps, 6.0).candidate.spec.target, "S1");
}

// Quantiles: chi-square with 1 degree of freedom, and F with 1 and 10, both at 1 %.
TEST(Screening, ScatterThatIsEstimatedIsNoKnownSigma) {
  EXPECT_NEAR(CorrectedP(6.6349, 1, 1.0, 10, 1), 0.01, 1e-6);
  EXPECT_NEAR(CorrectedP(6.6349, 1, 0.5, 10, 1), 0.01, 1e-6);
  EXPECT_NEAR(CorrectedP(2.0 * 10.0443, 1, 2.0, 10, 1), 0.01, 1e-6);
}

// Two columns that are nearly believed, and nearly the same: what they differ by holds as much rounding as meaning.
TEST(Screening, ABasisOfNearlyDependentColumnsStaysOrthonormal) {
  const int rows = 120;
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(rows, -1.0, 1.0);
  Eigen::MatrixXd believed(rows, 3);
  believed << Eigen::VectorXd::Ones(rows), x, x.cwiseAbs2();
  const Eigen::VectorXd residual = (7.0 * x).array().sin();
  Eigen::MatrixXd kind(rows, 2);
  kind.col(0) = believed * Eigen::Vector3d(1.0, -0.7, 0.3) + 1e-4 * (3.0 * x).array().sin().matrix();
  kind.col(1) = kind.col(0) + 1e-13 * (5.0 * x).array().cos().matrix();
  const ProjectedResidual beside = ProjectedResidual(believed, residual).With(kind);
  const Eigen::MatrixXd gram = beside.basis().transpose() * beside.basis();
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).norm(), 1e-12);
  EXPECT_EQ(gram.rows(), 5);
}

// What is believed already adds no direction.
TEST(Screening, NothingNewLeavesTheBasisAsItIs) {
  const Eigen::MatrixXd believed = Eigen::MatrixXd::Random(9, 3);
  const ProjectedResidual residual(believed, Eigen::VectorXd::Ones(9));
  EXPECT_EQ(residual.With(believed * Eigen::MatrixXd::Random(3, 5)).basis().cols(), 3);
}

// A joint that is 1 mrad higher on one side, beside bodies that move by four times the noise: the gain counts in that
// scatter, the size does not.
TEST(DiagnosisDecoys, SizesAreNotInUnitsOfTheScatter) {
  const DiagnosedModel healthy = Healthy(1);
  CalibrationProblem problem = *healthy.problem;
  Deviate(
      healthy, 3, [](const Eigen::VectorXd& q) { return q[3] > 0.3 ? 1000.0 : 0.0; }, &problem);
  for (const int i : problem.CalibrationObservations()) {
    Observation& observation = problem.data.observations[i];
    observation.point_in_station.z() += (observation.shot % 2 ? 4.0 : -4.0) * kSigma;
  }
  const DiagnosedModel model = FitFully(problem, JointOptions());
  const Decoy known = DecoyBench(model).Best(), scattered = DecoyBench(model).BestInScatter();
  EXPECT_LT(scattered.penalised, known.penalised);
  ASSERT_EQ(scattered.kind, "step") << scattered.words;
  const double size = std::stod(scattered.words.substr(scattered.words.find(" by ") + 4));
  EXPECT_NEAR(size, 1.0, 0.2) << scattered.words;
}

TEST(DiagnosisDecoys, AJointThatStandsStillDrivesNothing) {
  const DiagnosedModel model = Healthy(3, true);
  const DecoyBench bench(model);
  const Decoy decoy = bench.Best();
  EXPECT_EQ(std::count(decoy.depends_on.begin(), decoy.depends_on.end(), "A6"), 0);
  Decoy parked = decoy;
  parked.kind = "other";
  parked.acts_on = "A2";
  parked.depends_on = {"A3", "A6"};
  EXPECT_TRUE(bench.ColumnsOfKind(parked).allFinite());
}

TEST(SolveLinearization, FewerRowsThanColumnsIsNotOfFullRank) {
  Linearization few;
  few.jacobian = Eigen::MatrixXd::Random(2, 3);
  few.residual = Eigen::VectorXd::Ones(2);
  EXPECT_FALSE(SolveLinearization(few).full_rank);
}

TEST(FirstFound, IsTheSmallestWhateverTheThreads) {
  for (const int threads : {1, 2, 3, 8}) {
    const auto found =
        FirstFound<int>(10, threads, [](int i) { return i >= 4 ? std::optional<int>(i) : std::nullopt; });
    ASSERT_TRUE(found);
    EXPECT_EQ(*found, 4);
    EXPECT_FALSE(FirstFound<int>(4, threads, [](int) { return std::optional<int>(); }));
  }
}

}  // namespace
}  // namespace sagitta
