// Formulas of the diagnosis against closed forms, enumeration and other parts of the program: what is weighed, what is
// named, and what untouched rows say against it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/diagnosis/gap.h"
#include "estimator/diagnosis/outlier_rules.h"
#include "estimator/diagnosis/selected_effects.h"
#include "estimator/evidence/posterior.h"
#include "estimator/explanations/candidates.h"
#include "estimator/explanations/moments.h"
#include "problems/simulation.h"
#include "problems/text.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::diagnosis_formulas_test {
namespace {

constexpr double kSigma = 2e-5;  // m
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// 40 configurations of three markers, every fourth held out, one visit a minute from 1000 s on; `move` changes where
// the joints really are.
template <typename Move>
CalibrationProblem Moved(const Move& move, const Robot& believed) {
  Measurements data = test::MeasuredAfter(test::CampaignOf(40, 1, kSigma, 7), 107, move);
  for (size_t s = 0; s < data.shots.size(); ++s) {
    data.shots[s].has_time = true;
    data.shots[s].time = 1000.0 + 60.0 * static_cast<double>(s);
  }
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.25;
  return MakeCalibrationProblem(believed, data, experiment);
}

Robot Kr270() { return test::Kr270Robot(); }

CalibrationProblem Healthy() {
  return Moved([](Eigen::VectorXd*) {}, Kr270());
}

constexpr double kCosine = 80e-6, kSine = -50e-6;

// Joint 3 off by a harmonic of order 2.
CalibrationProblem Hidden() {
  return Moved([](Eigen::VectorXd* q) { (*q)[2] += kCosine * std::cos(2 * (*q)[2]) + kSine * std::sin(2 * (*q)[2]); },
               Kr270());
}

EffectSpec Harmonic(int joint) {
  EffectSpec spec;
  spec.effect = "joint_harmonic";
  spec.target = test::Kr270Chain().joints[static_cast<size_t>(joint)].name;
  spec.settings["order"] = "2";
  return spec;
}

TEST(DiagnosisFormulas, FactorOnSigmaIsARoot) {
  EXPECT_NEAR(ResidualLikelihood(10.0, kInfinity, 0.05).Factor(40.0), 2.0, 1e-12);
  EXPECT_NEAR(ResidualLikelihood(10.0, 30.0, 0.05).Factor(70.0), std::sqrt(100.0 / 40.0), 1e-12);
}

// Of two parameters both tails are elementary: exp(-x / 2), and (1 + 2 F / d)^(-d / 2).
TEST(DiagnosisFormulas, PIsOfTheBestOfManyTests) {
  EXPECT_NEAR(CorrectedP(12.0, 2, 0.8, 20, true, 5), 5.0 * std::exp(-6.0), 1e-12);
  const double of_f = std::pow(1.0 + 2.0 * 4.0 / 20.0, -10.0);
  EXPECT_NEAR(CorrectedP(12.0, 2, 1.5, 20, true, 3), 3.0 * of_f, 1e-12);
  EXPECT_NEAR(CorrectedP(12.0, 2, 1.5, 20, false, 3), 3.0 * of_f, 1e-12);
  EXPECT_EQ(CorrectedP(1.0, 2, 0.8, 20, true, 5), 1.0);
}

// exp(-v' C^-1 v / 2) of two parameters, with the values and the covariance of the estimate.
TEST(DiagnosisFormulas, WaldCountsTheEffectsParameters) {
  Robot believed = Kr270();
  believed.effects.push_back(Harmonic(2));
  const Estimate estimate =
      EstimateJointly(Moved([](Eigen::VectorXd* q) { (*q)[2] += 4e-6 * std::cos(2 * (*q)[2]); }, believed));
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  std::vector<int> own;
  Eigen::Vector2d values = Eigen::Vector2d::Zero();
  for (size_t c = 0; c < estimate.estimated.size(); ++c) {
    const ParameterEstimate& row = estimate.table[static_cast<size_t>(estimate.estimated[c])];
    if (row.name.find("joint_harmonic") == std::string::npos) continue;
    ASSERT_LT(own.size(), 2u);
    values[static_cast<long>(own.size())] = row.value;
    own.push_back(static_cast<int>(c));
  }
  ASSERT_EQ(own.size(), 2u);
  const double a = estimate.covariance(own[0], own[0]), b = estimate.covariance(own[0], own[1]),
               d = estimate.covariance(own[1], own[1]);
  const double square =
      (d * values[0] * values[0] - 2.0 * b * values[0] * values[1] + a * values[1] * values[1]) / (a * d - b * b);
  const double p = WaldP(Harmonic(2), estimate);
  EXPECT_NEAR(p / std::exp(-0.5 * square), 1.0, 1e-6);
  EXPECT_GT(p, 1e-12);
  EXPECT_LT(p, 0.9);
  EXPECT_EQ(WaldP(Harmonic(3), estimate), 1.0);  // of an effect that is not estimated
}

// What groups close adds up to what all effects close: by gap.cc, which goes by configurations.
TEST(DiagnosisFormulas, SharesOfTheGapAddUp) {
  const DiagnosedModel baseline = FitFully(Moved(
                                               [](Eigen::VectorXd* q) {
                                                 (*q)[2] += 160e-6 * std::cos(2 * (*q)[2]);
                                                 (*q)[1] *= 1.0 + 80e-6;
                                               },
                                               Kr270()),
                                           JointOptions());
  EffectSpec gain;
  gain.effect = "encoder_gain";
  gain.target = Harmonic(1).target;
  std::vector<FoundEffect> effects(2);
  effects[0].candidate.spec = Harmonic(2);
  effects[1].candidate.spec = gain;
  const DiagnosedModel final = Extend(baseline, {effects[0].candidate, effects[1].candidate}, JointOptions());
  const std::vector<EffectGroup> groups =
      GroupEffects(effects, baseline, baseline, final, final.estimate.noise_floor, JointOptions());
  ASSERT_EQ(groups.size(), 2u);
  DiagnosedModel judged = final;  // with its predictions
  judged.estimate.predicted = baseline.estimate.predicted;
  const std::vector<int> held_out = judged.problem->ValidationObservations();
  const Eigen::Matrix3Xd predicted = PredictPoints(*judged.problem, judged.estimate.parameters, held_out);
  for (size_t k = 0; k < held_out.size(); ++k) {
    judged.estimate.predicted.col(held_out[k]) = predicted.col(static_cast<long>(k));
  }
  const double closed = JudgeGap(baseline, judged, final.estimate.noise_floor, true).closed;
  EXPECT_GT(closed, 0.5);
  EXPECT_GT(std::abs(groups[0].share_of_gap), 0.05);
  EXPECT_GT(std::abs(groups[1].share_of_gap), 0.05);
  EXPECT_NEAR(groups[0].share_of_gap + groups[1].share_of_gap, closed, 1e-9);
  // The first alone closes its own share.
  DiagnosedModel first = Extend(baseline, {effects[0].candidate}, JointOptions());
  first.estimate.noise_floor = final.estimate.noise_floor;
  const double floor = std::pow(final.estimate.noise_floor, 2);
  const double before = std::pow(HoldoutRms(baseline), 2) - floor, after = std::pow(HoldoutRms(first), 2) - floor;
  EXPECT_NEAR(groups[0].share_of_gap, 1.0 - after / before, 1e-9);
}

// Chi-square's upper thousandth of one row is 16.27, of the worst of ninety 24.6.
TEST(DiagnosisFormulas, OutliersAreJudgedAsTheWorstOfAll) {
  const DiagnosedModel fit = FitFully(Healthy(), JointOptions());
  const std::vector<int> rows = fit.problem->CalibrationObservations();
  ASSERT_EQ(rows.size(), 90u);
  const auto found = [&](double square) {
    CalibrationProblem problem = *fit.problem;
    Observation& row = problem.mutable_data()->observations[static_cast<size_t>(rows[31])];
    row.point_in_station = fit.estimate.predicted.col(rows[31]) + kSigma * std::sqrt(square) * Vector3<double>::UnitX();
    return FindOutliers(problem, fit.estimate.parameters, rows, {1e-3});
  };
  EXPECT_TRUE(found(20.0).empty());
  EXPECT_EQ(found(40.0), std::vector<int>{rows[31]});
}

// Of 200 experiments 2 have an outlier by chance (significance 0.01), more than 6 one time in 200. noise: of a point,
// of 3 normal numbers, in units of what is stated.
int ExperimentsWithOutliers(
    const std::function<Vector3<double>(const Vector3<double>&, const Vector3<double>&)>& noise) {
  const DiagnosedModel fit = FitFully(Healthy(), JointOptions());
  const std::vector<int> rows = fit.problem->CalibrationObservations();
  NormalNumbers normal(77);
  int experiments = 0;
  for (int trial = 0; trial < 200; ++trial) {
    CalibrationProblem problem = *fit.problem;
    for (const int i : rows) {
      const Vector3<double> point = fit.estimate.predicted.col(i), drawn(normal(), normal(), normal());
      problem.mutable_data()->observations[static_cast<size_t>(i)].point_in_station =
          point + kSigma * noise(point, drawn);
    }
    experiments += !FindOutliers(problem, fit.estimate.parameters, rows, {0.01}).empty();
  }
  return experiments;
}

// What is off by 8 sigma across the line of sight is explained by no model that has it so, however far away it is.
TEST(DiagnosisFormulas, AnOutlierIsNotExplainedByItsDistance) {
  const DiagnosedModel fit = FitFully(Healthy(), JointOptions());
  const std::vector<int> rows = fit.problem->CalibrationObservations();
  const auto explained = [&](double sigmas) {
    CalibrationProblem problem = *fit.problem;
    Observation& row = problem.mutable_data()->observations[static_cast<size_t>(rows[31])];
    const Vector3<double> point = fit.estimate.predicted.col(rows[31]);
    EXPECT_GT(point.norm(), 2.0);  // m
    row.point_in_station = point + sigmas * kSigma * point.cross(Vector3<double>::UnitZ()).normalized();
    return ExplainedOutliers(problem, fit.estimate.parameters, {rows[31]}, 1e-3);
  };
  EXPECT_TRUE(explained(8.0).empty());
  EXPECT_EQ(explained(2.0), std::vector<int>{rows[31]});
}

// A tracker that reads ranges well and angles badly, or the other way round, stated as one figure; an instrument that
// reads one axis badly.
TEST(DiagnosisFormulas, ScatterInSomeDirectionsMakesNoOutliers) {
  EXPECT_LE(ExperimentsWithOutliers([](const Vector3<double>& point, const Vector3<double>& drawn) -> Vector3<double> {
              const Vector3<double> sight = point.normalized();
              return 1.5 * drawn - 1.3 * drawn.dot(sight) * sight;
            }),
            6);
  EXPECT_LE(ExperimentsWithOutliers([](const Vector3<double>& point, const Vector3<double>& drawn) -> Vector3<double> {
              const Vector3<double> sight = point.normalized();  // ranges are what it reads badly
              return 0.3 * drawn + 1.7 * drawn.dot(sight) * sight;
            }),
            6);
  EXPECT_LE(ExperimentsWithOutliers([](const Vector3<double>& point, const Vector3<double>& drawn) -> Vector3<double> {
              const Vector3<double> sight = point.normalized();  // by angles: it grows with the range
              return point.norm() * (drawn - drawn.dot(sight) * sight) + 0.3 * drawn.dot(sight) * sight;
            }),
            6);
  EXPECT_LE(ExperimentsWithOutliers([](const Vector3<double>&, const Vector3<double>& drawn) -> Vector3<double> {
              return drawn.cwiseProduct(Vector3<double>(0.5, 0.8, 1.5));
            }),
            6);
}

// Middles between the times of fitted visits; held-out visits make none.
TEST(DiagnosisFormulas, MomentsLieBetweenFittedVisits) {
  const CalibrationProblem problem = Healthy();
  std::vector<double> times;
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    const Shot& shot = problem.data().shots[s];
    if (!problem.data().configurations[static_cast<size_t>(shot.configuration)].is_validation) {
      times.push_back(60.0 * static_cast<double>(s));
    }
  }
  ASSERT_EQ(times.size(), 30u);
  const double begin = problem.shot_inputs()[0].conditions.time;  // of the campaign's clock
  const std::vector<std::string> points = ChangePoints(problem);
  ASSERT_EQ(points.size(), times.size() - 2);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(std::stod(points[i]) - begin, 0.5 * (times[i] + times[i + 1]), 1e-3) << i;
    EXPECT_EQ(points[i], FormatNumber(std::stod(points[i])));  // as files that are read back have it
  }
}

struct Weighed {
  std::unique_ptr<DiagnosedModel> model;
  std::unique_ptr<Evidence> evidence;
};

Weighed Weigh(const CalibrationProblem& problem) {
  Weighed weighed;
  weighed.model = std::make_unique<DiagnosedModel>(FitFully(problem, JointOptions()));
  const ParameterSet& parameters = weighed.model->estimate.parameters;
  weighed.evidence = std::make_unique<Evidence>(problem, parameters, ListCandidates(problem, parameters), PriorMasses(),
                                                kInfinity, nullptr);
  return weighed;
}

// Where a cause is certain, how probable "nothing" was decides nothing any more: neither between causes, nor whether a
// deviation that follows the pose is one more.
TEST(DiagnosisFormulas, WhatIsRefutedHasNoSay) {
  const test::Kr270Design design = test::CampaignOf(40, 1, 2e-5, 5);
  Measurements data = test::DesignMeasurements(design);
  test::VisitAgain(design, &data);
  Measurements moved = data;
  std::mt19937_64 random(91);
  std::normal_distribution<double> off(0.0, 2e-5);
  for (int c = 0; c < design.configurations; ++c) {
    Eigen::VectorXd& q = moved.configurations[c].q;
    for (double& joint : q) joint += off(random);
    q[2] += 4e-4 * std::cos(2.0 * data.configurations[c].q[2]);
    moved.configurations[c + design.configurations].q = q;
  }
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 92, &moved);
  for (size_t i = 0; i < data.observations.size(); ++i)
    data.observations[i].point_in_station = moved.observations[i].point_in_station;
  const CalibrationProblem problem = test::Kr270ProblemOf(data, Experiment());
  const ParameterSet parameters = EstimateJointly(problem).parameters;
  const CandidateList candidates = ListCandidates(problem, parameters);
  std::map<std::pair<NoiseView::Kind, std::vector<int>>, double> weights[2];
  for (const int k : {0, 1}) {
    const PriorMasses masses = k == 0 ? PriorMasses{0.5, 0.38, 0.12, 0.3} : PriorMasses{0.02, 0.7448, 0.2352, 0.3};
    const Evidence evidence(problem, parameters, candidates, masses, kInfinity, nullptr);
    for (const WeightedModel& model : evidence.models())
      weights[k][{evidence.ViewOf(model).kind, model.set.members}] = model.log_weight;
  }
  int with_pose = 0;
  for (const auto& [key, weight] : weights[0]) {
    if (key.second.empty() || weights[1].count(key) == 0) continue;
    EXPECT_NEAR(weights[1].at(key) - weight, std::log(0.98 / 0.5), 1e-6);
    with_pose += key.first == NoiseView::Kind::kPose ? 1 : 0;
  }
  EXPECT_GT(with_pose, 0);
}

// Sums over all models, written out.
TEST(DiagnosisFormulas, PosteriorsAreSumsOverSets) {
  // Too small to be sure of: several sets share the probability.
  const Weighed weighed = Weigh(Moved([](Eigen::VectorXd* q) { (*q)[2] += 9e-6 * std::cos(2 * (*q)[2]); }, Kr270()));
  const Evidence& evidence = *weighed.evidence;
  const Posterior posterior = PosteriorOf(evidence, evidence.models());
  const ExplanationList& list = evidence.list();
  double nothing = 0.0, noise = 0.0, unnamed = 0.0, all = 0.0;
  std::map<std::string, double> names;
  std::map<std::set<std::string>, double> sets;
  for (const WeightedModel& model : evidence.models()) {
    ASSERT_NE(evidence.views()[model.view].view.kind, NoiseView::Kind::kPose);
    all += model.probability;
    std::set<std::string> own;
    bool has_unnamed = false;
    for (const int m : model.set.members) {
      if (model.HasPiece(m)) continue;
      own.insert(list.name[m]);
      has_unnamed |= list.IsUnnamed(m);
    }
    for (const std::string& name : own) names[name] += model.probability;
    if (has_unnamed) unnamed += model.probability;
    if (!own.empty()) sets[own] += model.probability;
    if (!own.empty()) continue;
    const bool stated = evidence.views()[model.view].view.kind == NoiseView::Kind::kStated;
    const double wrong = stated ? evidence.LikelihoodOf(model.view)
                                      .ProbabilityWrong(evidence.views()[model.view].given_believed.normal.residual)
                                : 1.0;
    nothing += (1.0 - wrong) * model.probability;
    noise += wrong * model.probability;
  }
  EXPECT_NEAR(all, 1.0, 1e-9);
  EXPECT_NEAR(posterior.nothing, nothing, 1e-12);
  EXPECT_NEAR(posterior.noise, noise, 1e-12);
  EXPECT_NEAR(posterior.unnamed, unnamed, 1e-12);
  EXPECT_GT(nothing, 0.001);
  EXPECT_GT(unnamed, 1e-4);
  EXPECT_GT(std::abs(nothing - noise), 0.001);
  ASSERT_EQ(posterior.sets.size(), sets.size());
  std::vector<std::string> in_order = list.name;
  std::sort(in_order.begin(), in_order.end());
  in_order.erase(std::unique(in_order.begin(), in_order.end()), in_order.end());
  bool is_shared = false;  // a set of names by more than one model
  for (const NameSet& set : posterior.sets) {
    std::set<std::string> own;
    for (const int place : set.names) own.insert(in_order[static_cast<size_t>(place)]);
    EXPECT_NEAR(set.probability, sets.at(own), 1e-12);
    is_shared |= set.models.size() > 1 && set.probability > 1.001 * evidence.models()[set.best].probability;
  }
  EXPECT_TRUE(is_shared);
  for (const auto& [name, probability] : names) EXPECT_NEAR(posterior.Of(name), probability, 1e-12) << name;
}

// Three times the prior of nothing: odds of something become a third.
TEST(DiagnosisFormulas, AnotherPriorFlipsAVerdictNearItsGate) {
  const Weighed weighed = Weigh(Moved([](Eigen::VectorXd* q) { (*q)[2] += 9e-6 * std::cos(2 * (*q)[2]); }, Kr270()));
  const Posterior posterior = PosteriorOf(*weighed.evidence, weighed.evidence->models());
  const double something = posterior.Something(), odds = something / (1.0 - something);
  ASSERT_GT(something, 0.01);
  ASSERT_LT(something, 0.999);
  const double then = odds / 3.0 / (1.0 + odds / 3.0);
  const auto flips_to_nothing = [&](double gate) {
    const std::vector<Flip> flips = WhatFlips(*weighed.evidence, posterior, gate);
    return std::any_of(flips.begin(), flips.end(),
                       [](const Flip& flip) { return flip.mass == "nothing" && flip.is_larger && !flip.is_something; });
  };
  EXPECT_FALSE(flips_to_nothing(then - 1e-6));
  EXPECT_TRUE(flips_to_nothing(then + 1e-6));
  EXPECT_TRUE(flips_to_nothing(something - 1e-6));
}

// With other masses the evidence weighs its sets as it says that it would: small ones, all of whose scales are
// averaged.
TEST(DiagnosisFormulas, AnotherPriorWeighsAsTheRatioSays) {
  const CalibrationProblem problem = Hidden();
  const ParameterSet parameters = FitFully(problem, JointOptions()).estimate.parameters;
  const auto weighed = [&](const PriorMasses& masses) {
    return std::make_unique<Evidence>(problem, parameters, ListCandidates(problem, parameters), masses, kInfinity,
                                      nullptr);
  };
  const std::unique_ptr<Evidence> now = weighed({});
  for (const PriorMasses& masses : {PriorMasses{0.2, 0.7, 0.1, 0.3}, PriorMasses{0.5, 0.2, 0.3, 0.6}}) {
    const std::unique_ptr<Evidence> then = weighed(masses);
    std::map<size_t, int> compared;  // by members
    for (const WeightedModel& model : now->models()) {
      const auto same = std::find_if(then->models().begin(), then->models().end(), [&](const WeightedModel& other) {
        return other.view == model.view && other.set.members == model.set.members && other.pieces == model.pieces &&
               other.set.scales == model.set.scales;
      });
      if (same == then->models().end() || !now->ViewOf(model).IsStated() || model.set.members.size() > 2) continue;
      EXPECT_NEAR(LogPriorRatio(*now, model, masses), same->log_weight - model.log_weight, 0.01);
      ++compared[model.set.members.size()];
    }
    EXPECT_GT(compared[1], 0);
    EXPECT_GT(compared[2], 0);
  }
}

// Of the chi-square that a refit loses, and of the halves' values being one.
TEST(DiagnosisFormulas, AnEffectsReductionAndHalves) {
  const CalibrationProblem problem = Hidden();
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  const FoundEffect& effect = diagnosis.effects[0];
  const double lost = diagnosis.baseline.estimate.chi2 - diagnosis.final.estimate.chi2;
  EXPECT_GT(lost, 20.0);
  EXPECT_NEAR(effect.reduction, lost, 0.01 * lost);
  ASSERT_EQ(effect.confirmation.halves.size(), 2u);
  const HalfResult &first = effect.confirmation.halves[0], &second = effect.confirmation.halves[1];
  ASSERT_EQ(first.values.size(), 2);
  const Eigen::Vector2d apart = first.values - second.values;
  const Eigen::Matrix2d covariance = first.covariance + second.covariance;
  EXPECT_NEAR(effect.confirmation.compatible_p, std::exp(-0.5 * apart.dot(covariance.inverse() * apart)), 1e-9);
}

// A family's mass is shared equally by its targets, a target's by its settings; the catalogue has 0.38 and what is
// unnamed 0.12 of what is not nothing. Six of the 124 orders of a ripple beyond the catalogue's six are
// listed of each joint, and those that are not have their share too.
TEST(DiagnosisFormulas, MassesAreSharedLevelByLevel) {
  const CalibrationProblem problem = Healthy();
  const CandidateList candidates = ListCandidates(problem, problem.parameters);
  EvidenceColumns columns(problem, problem.parameters, candidates.candidates);
  const ExplanationList list = ListExplanations(problem, problem.parameters, candidates, PriorMasses(), &columns);
  std::set<int> fitted;  // configurations, none with the angles of another
  for (const int i : problem.CalibrationObservations()) {
    fitted.insert(problem.data().shots[problem.data().observations[i].shot].configuration);
  }
  // Of all gaps; of a loose part's, with three shots beyond either end, in 200 directions; of all orders; of waves in
  // time, in halves, from one over the campaign to one over two visits.
  const double n = static_cast<double>(fitted.size());
  // In quarters over the span of the ranges, from four to two per reading, or 400.
  const double quarters = std::min(400.0, 2.0 * static_cast<double>(problem.CalibrationObservations().size())) - 3.0;
  const std::map<std::string, double> share_listed = {{"learnt_jump_deviation", 8.0 / (n - 1.0)},
                                                      {"learnt_marker_seat", 6.0 / (200.0 * (n - 5.0))},
                                                      {"joint_harmonic", 6.0 / 124.0},
                                                      {"learnt_station_wave", 6.0 / (n - 1.0)},
                                                      {"learnt_range_wave", 4.0 / quarters}};
  std::map<bool, double> masses;
  std::map<std::pair<bool, std::string>, std::map<std::string, double>> targets;
  std::map<std::pair<bool, std::string>, std::map<std::string, std::set<double>>> settings;
  for (size_t k = 0; k < list.math.size(); ++k) {
    const bool unnamed = list.IsUnnamed(static_cast<int>(k));
    const double listed = list.place[k].listed, share = list.math[k].share / listed;
    const std::vector<EffectSpec> effects =
        unnamed ? list.functions[list.unnamed[k]].effects : std::vector<EffectSpec>{EffectSpec()};
    const std::string effect = effects.at(0).effect;
    double expected = share_listed.count(effect) > 0 ? share_listed.at(effect) : 1.0;
    if (effects[0].IntegerSetting("knots", 0) == 1) {  // so many jumps in time: one of n - 1 over k
      std::set<std::string> jumps;                     // of a body that moves and turns two effects each
      for (const EffectSpec& jump : effects) jumps.insert(jump.TextSetting("from", ""));
      for (size_t i = 0; i < jumps.size(); ++i) {
        expected *= (static_cast<double>(i) + 1.0) / (n - 1.0 - static_cast<double>(i));
      }
    }
    EXPECT_NEAR(listed / expected, 1.0, 1e-9) << effect;
    masses[unnamed] += share;
    targets[{unnamed, list.place[k].family}][list.place[k].target] += share;
    settings[{unnamed, list.place[k].family}][list.place[k].target].insert(std::round(1e12 * share));
  }
  EXPECT_NEAR(masses[false], 0.38 / 0.5, 1e-9);
  EXPECT_NEAR(masses[true], 0.12 / 0.5, 1e-9);
  for (const bool unnamed : {false, true}) {
    double least = 1.0, most = 0.0;
    for (const auto& [family, shares] : targets) {
      if (family.first != unnamed) continue;
      double sum = 0.0, lowest = 1.0, highest = 0.0;
      for (const auto& [target, share] : shares) {
        sum += share;
        lowest = std::min(lowest, share);
        highest = std::max(highest, share);
        EXPECT_EQ(settings[family][target].size(), 1u) << family.second << " " << target;
      }
      EXPECT_NEAR(highest / lowest, 1.0, 1e-9) << family.second;
      least = std::min(least, sum);
      most = std::max(most, sum);
    }
    EXPECT_GT(most, 0.0);
    EXPECT_NEAR(most / least, 1.0, 1e-9);
  }
}

}  // namespace
}  // namespace sagitta::diagnosis_formulas_test
