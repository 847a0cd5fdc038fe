// Parts of the diagnosis alone: what can be tested, what counts as an outlier.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/diagnosis/noise_check.h"
#include "estimator/diagnosis/outlier_rules.h"
#include "estimator/diagnosis/selected_effects.h"
#include "estimator/explanations/candidates.h"
#include "estimator/least_squares/linearization.h"
#include "problems/loads.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::diagnosis_parts_test {
namespace {

constexpr double kSigma = 2e-5;         // m
constexpr double kSignificance = 1e-3;  // of outliers

// 40 configurations, three markers on the flange, a quarter held out; joint 6 stands still where asked.
DiagnosedModel Healthy(std::uint64_t seed, bool parked = false) {
  Measurements data = test::DesignMeasurements(test::CampaignOf(40, 1, kSigma, seed));
  for (Configuration& configuration : data.configurations) {
    if (parked) configuration.q[5] = 0.5;
  }
  test::MeasureKr270(test::Kr270Truth(), kSigma, 300 + seed, &data);
  const Robot robot = test::Kr270Robot();
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.25;
  return FitFully(MakeCalibrationProblem(robot, data, experiment), JointOptions());
}

// Rows need not be in the order of time: the first of a station is its earliest.
TEST(Conditions, TimeCountsFromTheFirstRowOfAStation) {
  const CalibrationProblem problem = *Healthy(1).problem;
  Measurements data = problem.data();
  for (size_t s = 0; s < data.shots.size(); ++s) {
    data.shots[s].has_time = true;
    data.shots[s].time = 100.0 - 5.0 * static_cast<double>(s);
  }
  const std::vector<ShotInput> inputs = MakeShotInputs(problem.model(), data, problem.experiment());
  for (size_t s = 0; s < inputs.size(); ++s) {
    EXPECT_EQ(inputs[s].conditions.time, 5.0 * static_cast<double>(inputs.size() - 1 - s));
  }
}

// A shot counts at the mean of its rows, the clock of the station starts with its first row.
TEST(Conditions, TheFirstRowIsNotItsShot) {
  const CalibrationProblem problem = *Healthy(1).problem;
  Measurements data = problem.data();
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
  const std::vector<ShotInput> inputs = MakeShotInputs(problem.model(), data, problem.experiment());
  for (size_t s = 0; s < inputs.size(); ++s) {
    EXPECT_NEAR(inputs[s].conditions.time, data.shots[s].time - 1000.0, 1e-9);
  }
  EXPECT_GT(inputs[0].conditions.time, 1.0);
}

// What an effect says of a joint that slides is defined or it is not asked; what never changes drives nothing.
TEST(Candidates, WhatCannotBeTestedIsListedWithItsReason) {
  const CalibrationProblem healthy = *Healthy(1).problem;
  Robot robot = healthy.robot();
  robot.chain.joints[2].type = JointType::kPrismatic;
  robot.chain.transforms[robot.chain.JointTransform(2)].motion = Motion::kTranslation;
  CalibrationProblem problem = MakeCalibrationProblem(robot, healthy.data(), healthy.experiment());
  for (ShotInput& shot : *problem.mutable_shot_inputs()) {
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
  EXPECT_EQ(need_of("joint_slip", "A3"), "time_s that varies");  // a joint that slides may slip, too
  EXPECT_EQ(need_of("backlash", "A3"), "approach3");
  EXPECT_FALSE(is_candidate("joint_slip", "A1"));
  EXPECT_EQ(need_of("joint_slip", "A1"), "time_s that varies");
  EXPECT_EQ(need_of("thermal_growth", "robot"), "temperature_degC");
  EXPECT_EQ(need_of("link_gravity", "A2"), "joint compliances above 0 (loaded rows)");
  EXPECT_TRUE(is_candidate("self_weight_sag", "A2"));
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
  problem.mutable_experiment()->stations[problem.data().stations[0]].levelled = false;
  const CandidateList unlevelled = ListCandidates(problem, problem.parameters);
  EXPECT_EQ(of_sag(unlevelled), 0);
  EXPECT_EQ(unlevelled.candidates.size(), levelled.candidates.size() - of_sag(levelled));
  const bool says_why =
      std::any_of(unlevelled.not_testable.begin(), unlevelled.not_testable.end(), [](const NotTestable& entry) {
        return entry.effect == "self_weight_sag" && entry.needs.find("gravity") != std::string::npos;
      });
  EXPECT_TRUE(says_why);
  problem.mutable_experiment()->gravity_in_base = true;
  EXPECT_EQ(of_sag(ListCandidates(problem, problem.parameters)), of_sag(levelled));
}

std::vector<int> Outliers(const DiagnosedModel& model, bool held_out) {
  const CalibrationProblem& problem = *model.problem;
  std::vector<int> found = FindOutliers(problem, model.estimate.parameters,
                                        held_out ? problem.ValidationObservations() : problem.CalibrationObservations(),
                                        {kSignificance, held_out});
  std::sort(found.begin(), found.end());
  return found;
}

// 40 sigma: far beyond the limit of about 5.
void Spoil(DiagnosedModel* model, const std::vector<int>& observations) {
  CalibrationProblem problem = *model->problem;
  double sign = 1.0;
  for (const int i : observations) {
    problem.mutable_data()->observations[i].point_in_station += sign * Vector3<double>(40 * kSigma, 0.0, 0.0);
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
      model.problem->data()
          .shots[model.problem->data().observations[model.problem->CalibrationObservations()[0]].shot]
          .observations;
  ASSERT_EQ(shot.size(), 3u);
  const std::vector<int> spoilt = {shot[0], shot[2]};
  Spoil(&model, spoilt);
  EXPECT_EQ(Outliers(model, false), spoilt);
}

TEST(DiagnosisOutliers, HeldOutRowsAreJudgedByTheirBody) {
  DiagnosedModel model = Healthy(1);
  const std::vector<int> held_out = model.problem->ValidationObservations();
  Spoil(&model, {held_out[4]});
  EXPECT_EQ(Outliers(model, true), std::vector<int>{held_out[4]});
  // All three markers of a shot off alike: the model's error, not theirs.
  DiagnosedModel moved = Healthy(1);
  CalibrationProblem problem = *moved.problem;
  const Shot& shot = problem.data().shots[problem.data().observations[held_out[0]].shot];
  for (const int i : shot.observations) problem.mutable_data()->observations[i].point_in_station.x() += 40 * kSigma;
  moved.problem = std::make_shared<CalibrationProblem>(problem);
  EXPECT_TRUE(Outliers(moved, true).empty());
}

// One marker, ten poses that were not fitted: a reading that is off by far more than all but two others is its own
// mistake. What three of them do could be the robot.
TEST(DiagnosisOutliers, OneHeldOutReadingOfOneMarkerIsFound) {
  const auto of_one_marker = [](const std::vector<size_t>& spoilt) {
    DiagnosedModel model = Healthy(1);
    CalibrationProblem problem = *model.problem;
    for (size_t i = 0; i < problem.data().observations.size(); ++i) {
      if (problem.data().observations[i].marker > 0) problem.mutable_data()->ExcludeRow(static_cast<int>(i));
    }
    model.problem = std::make_shared<CalibrationProblem>(problem);
    const std::vector<int> held_out = problem.ValidationObservations();
    EXPECT_EQ(held_out.size(), 10u);
    std::vector<int> rows;
    for (const size_t k : spoilt) rows.push_back(held_out[k]);
    Spoil(&model, rows);
    return std::pair(Outliers(model, true), rows);
  };
  for (const std::vector<size_t>& few : {std::vector<size_t>{6}, {2, 6}}) {
    const auto [found, rows] = of_one_marker(few);
    EXPECT_EQ(found, rows);
  }
  EXPECT_TRUE(of_one_marker({2, 6, 8}).first.empty());
}

// Markers of one shot on two bodies: that one moves against the other is no noise. Two markers keep one distance, so of
// 30 fitted configurations 30 - 1 degrees of freedom are left.
TEST(DiagnosisNoise, BodiesAreRigidEachForItself) {
  DiagnosedModel model = Healthy(2);
  CalibrationProblem problem = *model.problem;
  for (Observation& observation : problem.mutable_data()->observations) {
    if (observation.marker == 2) observation.point_in_station.y() += 3e-3 * std::sin(observation.shot);
  }
  const auto together = InstrumentNoiseScale(problem, model.estimate.parameters);
  ASSERT_TRUE(together);
  EXPECT_GT(together->scale, 10.0);
  problem.set_marker_frame(2, problem.marker_frames()[0] - 1);  // as if on the link before
  const auto apart = InstrumentNoiseScale(problem, model.estimate.parameters);
  ASSERT_TRUE(apart);
  EXPECT_EQ(apart->dof, 29);
  EXPECT_LT(apart->low, 1.0);
  EXPECT_GT(apart->high, 1.0);
}

TEST(SolveLinearization, FewerRowsThanColumnsIsNotOfFullRank) {
  Linearization few;
  few.jacobian = Eigen::MatrixXd::Random(2, 3);
  few.residual = Eigen::VectorXd::Ones(2);
  EXPECT_FALSE(SolveLinearization(few).full_rank);
}

}  // namespace
}  // namespace sagitta::diagnosis_parts_test
