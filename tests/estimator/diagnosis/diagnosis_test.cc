// The diagnosis on data in which an effect is hidden; the measurements come from
// the generator in tests/support, the effect from its formula written here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "estimator/diagnosis/cautions.h"
#include "estimator/diagnosis/diagnose.h"
#include "estimator/diagnosis/learnt_model.h"
#include "estimator/diagnosis/noise_check.h"
#include "estimator/report/diagnosis_words.h"
#include "estimator/results/diagnosis_json.h"
#include "estimator/sagitta.h"
#include "models/constants.h"
#include "tests/support/hidden_kr270.h"

namespace sagitta::diagnosis_test {
namespace {

using test::Hidden;
using test::Moved;

constexpr double kSigma = 2e-5;  // m

TEST(Diagnosis, NothingHiddenIsConsistent) {
  const Diagnosis diagnosis = Diagnose(Hidden(1, [](double) { return 0.0; }), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kConsistent);
  EXPECT_TRUE(diagnosis.effects.empty());
}

TEST(Diagnosis, NamesAHarmonicWithItsSizeAndClosesTheGap) {
  const auto harmonic = [](double q) { return 80e-6 * std::cos(2 * q) - 50e-6 * std::sin(2 * q); };
  const Diagnosis diagnosis = Diagnose(Hidden(2, harmonic), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.effects[0].candidate.spec.Path(), "effect/joint_harmonic[order=2]/A3");
  const std::vector<ParameterEstimate>& parameters = diagnosis.effects[0].parameters;
  ASSERT_EQ(parameters.size(), 2u);
  EXPECT_NEAR(parameters[0].value, 80e-6, 5 * parameters[0].sigma);
  EXPECT_NEAR(parameters[1].value, -50e-6, 5 * parameters[1].sigma);
  EXPECT_LT(diagnosis.gap.after, 0.3 * diagnosis.gap.before);
  const Confirmation& confirmation = diagnosis.effects[0].confirmation;
  ASSERT_EQ(confirmation.halves.size(), 2u);
  for (const HalfResult& half : confirmation.halves) {
    EXPECT_GT(half.probability, 0.5) << half.best;
    ASSERT_EQ(half.values.size(), 2);  // in typical sizes, 75 urad
    EXPECT_NEAR(75e-6 * half.values[0], 80e-6, 5 * 75e-6 * std::sqrt(half.covariance(0, 0)));
    EXPECT_NEAR(75e-6 * half.values[1], -50e-6, 5 * 75e-6 * std::sqrt(half.covariance(1, 1)));
  }
  EXPECT_GT(confirmation.compatible_p, 1e-4);
  EXPECT_GT(diagnosis.effects[0].probability, 0.9);
  double sum = diagnosis.posterior.nothing + diagnosis.posterior.noise;
  for (const NamedSet& set : diagnosis.posterior.sets) sum += set.probability;
  EXPECT_GT(sum, 0.99);
  EXPECT_LT(sum, 1.0 + 1e-9);
  ASSERT_EQ(diagnosis.groups.size(), 1u);
  EXPECT_NEAR(diagnosis.groups[0].share_of_gap, 1.0, 1e-9);
}

// A ripple in the fitted rows that the held-out rows do not have: it explains the former, and the latter have a veto.
TEST(Diagnosis, WhatMakesUntouchedRowsWorseIsNoStep) {
  CalibrationProblem problem = Hidden(2, [](double q) { return 80e-6 * std::cos(2 * q) - 50e-6 * std::sin(2 * q); });
  const CalibrationProblem healthy = Hidden(2, [](double) { return 0.0; });
  const std::vector<int> held_out = problem.ValidationObservations();
  ASSERT_EQ(held_out.size(), 45u);
  for (const int i : held_out) {
    problem.mutable_data()->observations[i].point_in_station = healthy.data().observations[i].point_in_station;
  }
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_NE(diagnosis.verdict, DiagnosisVerdict::kExplained);
  for (const FoundEffect& effect : diagnosis.effects) {
    EXPECT_NE(effect.candidate.spec.Path(), "effect/joint_harmonic[order=2]/A3");
  }
  EXPECT_LT(diagnosis.final.estimate.validation.rms, 1.01 * diagnosis.baseline.estimate.validation.rms);
}

// A joint that slips between two fitted visits, with three held-out ones between these: on which side they are no
// fitted row says, and no figure counts them.
TEST(Diagnosis, HeldOutVisitsNextToAMomentAreNoGap) {
  int configuration = 0;
  Measurements data = test::MeasuredAfter(test::CampaignOf(50, 1, kSigma, 5), 105,
                                          [&](Eigen::VectorXd* q) { (*q)[2] += configuration++ < 25 ? 0.0 : 300e-6; });
  for (Shot& shot : data.shots) shot.has_time = true, shot.time = 60.0 * shot.configuration;
  CalibrationProblem problem = MakeCalibrationProblem(test::Kr270Robot(), data, Experiment());
  for (int c = 0; c < 50; ++c)
    problem.mutable_data()->configurations[c].is_validation = c % 4 == 0 || c == 25 || c == 26;
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.effects[0].candidate.spec.effect, "joint_slip");
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  EXPECT_GT(diagnosis.gap.closed, 0.9);
  EXPECT_EQ(diagnosis.final.estimate.validation.observations, 3 * 12);
  EXPECT_EQ(diagnosis.baseline.estimate.validation.observations, 3 * 12);
  EXPECT_THAT(diagnosis.cautions, ::testing::Contains(::testing::StartsWith("Held out, but in no figure: ")));
}

TEST(Diagnosis, MeasuredAndSimulatedFollowTheDriver) {
  const auto harmonic = [](double q) { return 80e-6 * std::cos(2 * q) - 50e-6 * std::sin(2 * q); };
  const Diagnosis diagnosis = Diagnose(Hidden(2, harmonic), DiagnosisOptions());
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  const EffectView& view = diagnosis.effects[0].view;
  EXPECT_EQ(view.driver, "A3");
  EXPECT_EQ(view.unit, "urad");
  ASSERT_GE(view.x.size(), 30u);
  double squared = 0.0;
  for (size_t i = 0; i < view.x.size(); ++i) {
    const double q = view.x[i] / 57.29577951308232;
    EXPECT_NEAR(view.simulated[i], 1e6 * harmonic(q), 25.0);  // 5 standard deviations of either coefficient
    squared += std::pow(view.measured[i] - 1e6 * harmonic(q), 2);
  }
  // 20 um on three markers about 2 m away, less what base and geometry absorb: below 40 urad.
  EXPECT_LT(std::sqrt(squared / static_cast<double>(view.x.size())), 40.0);
}

bool AnyStartsWith(const std::vector<std::string>& cautions, const std::string& start) {
  return std::any_of(cautions.begin(), cautions.end(),
                     [&](const std::string& caution) { return caution.rfind(start, 0) == 0; });
}

TEST(Diagnosis, WhatLimitsTheVerdictIsSaid) {
  const CalibrationProblem healthy = Hidden(1, [](double) { return 0.0; });
  EXPECT_TRUE(Diagnose(healthy, DiagnosisOptions()).cautions.empty());

  CalibrationProblem silent = healthy;
  for (Observation& observation : silent.mutable_data()->observations) observation.sigma.setZero();
  EXPECT_TRUE(AnyStartsWith(Diagnose(silent, DiagnosisOptions()).cautions, "No noise is stated"));

  CalibrationProblem shared = healthy;
  std::vector<Configuration>& configurations = shared.mutable_data()->configurations;
  const auto held_out = std::find_if(configurations.begin(), configurations.end(),
                                     [](const Configuration& c) { return c.is_validation; });
  const auto fitted = std::find_if(configurations.begin(), configurations.end(),
                                   [](const Configuration& c) { return !c.is_validation; });
  held_out->q = fitted->q;
  DiagnosedModel believed;
  believed.problem = std::make_shared<CalibrationProblem>(shared);
  EXPECT_TRUE(
      AnyStartsWith(FindCautions(*believed.problem, believed), "1 configuration is fitted and held out at once"));

  CalibrationProblem alike = shared, sorted = shared;
  for (Configuration& configuration : alike.mutable_data()->configurations)
    configuration.q = shared.data().configurations[0].q;
  believed.problem = std::make_shared<CalibrationProblem>(alike);
  EXPECT_TRUE(AnyStartsWith(FindCautions(*believed.problem, believed), "All configurations are alike"));
  EXPECT_TRUE(AnyStartsWith(FindCautions(*believed.problem, believed), "Only 1 different configurations"));

  for (Shot& shot : sorted.mutable_data()->shots) shot.has_time = false;
  const auto is_said = [&] {
    for (const std::string& caution : FindCautions(sorted, believed)) {
      if (caution.find("the order of the rows") != std::string::npos) return true;
    }
    return false;
  };
  EXPECT_FALSE(is_said());
  // A joint that moves once in the middle and once at the end follows no order.
  for (Configuration& configuration : sorted.mutable_data()->configurations) configuration.q[5] = 0.0;
  sorted.mutable_data()->configurations[sorted.data().configurations.size() / 2].q[5] = 1.0;
  sorted.mutable_data()->configurations.back().q[5] = 1.0;
  EXPECT_FALSE(is_said());
  std::vector<Configuration>& in_order = sorted.mutable_data()->configurations;
  for (size_t c = 0; c < in_order.size(); ++c)
    in_order[c].q[3] = -0.05 * static_cast<double>(c) + 0.2 * std::sin(1.0 * static_cast<double>(c * c));
  EXPECT_TRUE(AnyStartsWith(FindCautions(sorted, believed), "A4 follows the order of the rows"));
}

// Where more than a few cells are empty, the column is silent.
TEST(Diagnosis, ColumnsThatSomeRowsDoNotStateAreNamed) {
  CalibrationProblem partly = Hidden(1, [](double) { return 0.0; });
  const DiagnosedModel believed{std::make_shared<CalibrationProblem>(partly), {}};
  for (size_t s = 0; s < partly.shot_inputs().size(); ++s) {
    (*partly.mutable_shot_inputs())[s].conditions.has_time = s % 2 == 0;
  }
  const std::string words = "Columns that some rows do not state: time_s (";
  EXPECT_TRUE(AnyStartsWith(FindCautions(partly, believed), words));
  for (ShotInput& shot : *partly.mutable_shot_inputs()) shot.conditions.has_time = true;
  EXPECT_FALSE(AnyStartsWith(FindCautions(partly, believed), words));
}

// A direction that is 0 or the same throughout is none that play could follow.
TEST(Diagnosis, PlayNeedsADirectionThatVaries) {
  CalibrationProblem problem = Hidden(1, [](double) { return 0.0; });
  for (size_t s = 0; s < problem.shot_inputs().size(); ++s) {
    (*problem.mutable_shot_inputs())[s].conditions.approach = {1, s % 2 == 0 ? 1 : -1, 0, 0, 0, 0};
  }
  std::map<std::string, std::string> needs;
  for (const NotTestable& entry : ListCandidates(problem, problem.parameters).not_testable) {
    if (entry.effect == "backlash") needs[entry.target] = entry.needs;
  }
  EXPECT_EQ(needs["A1"], "approach1 that varies");
  EXPECT_EQ(needs.count("A2"), 0u);
  EXPECT_EQ(needs["A3"], "approach3");
}

// Where no joint moves and no time is stated there is nothing that could drive anything.
TEST(Diagnosis, OnePoseWithoutTimeHasAVerdict) {
  CalibrationProblem problem = Moved(5, [](Eigen::VectorXd* q) { q->setConstant(0.3); });
  for (Configuration& configuration : problem.mutable_data()->configurations) configuration.q.setConstant(0.3);
  for (ShotInput& shot : *problem.mutable_shot_inputs()) {
    shot.conditions.q.setConstant(0.3);
    shot.conditions.has_time = false;
    shot.conditions.time = 0.0;
  }
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    problem.mutable_data()->observations[i].point_in_station.x() += i % 2 == 0 ? 1e-3 : -1e-3;
  }
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_NE(WordOf(diagnosis.verdict), "");
  EXPECT_TRUE(AnyStartsWith(diagnosis.cautions, "All configurations are alike"));
}

TEST(Diagnosis, WithoutHoldoutThereIsNoGapFigure) {
  CalibrationProblem problem = Hidden(2, [](double q) { return 80e-6 * std::cos(2 * q); });
  for (Configuration& configuration : problem.mutable_data()->configurations) configuration.is_validation = false;
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  EXPECT_TRUE(std::isnan(diagnosis.gap.closed));
  EXPECT_TRUE(std::isnan(diagnosis.gap.closed_ci95.low));
  EXPECT_TRUE(std::isnan(diagnosis.effects.at(0).holdout_after));
  EXPECT_TRUE(AnyStartsWith(diagnosis.cautions, "Nothing is held out"));
}

// One marker, each pose once, no sigma stated: the scatter is the noise, first about the believed model, then about the
// extended one.
TEST(Diagnosis, OpenSigmaFollowsWhatIsNamed) {
  CalibrationProblem problem = Hidden(2, [](double q) { return 300e-6 * std::cos(2 * q) - 200e-6 * std::sin(2 * q); });
  for (Observation& observation : problem.mutable_data()->observations) {
    observation.sigma.setZero();
    observation.excluded = observation.marker != 0;
  }
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.effects[0].candidate.spec.Path(), "effect/joint_harmonic[order=2]/A3");
  // 105 rows less about 35 unknowns determine sigma to 8 % and predict with up to sqrt(1.5) of it.
  EXPECT_NEAR(diagnosis.final.estimate.noise_floor, 1.2 * kSigma, 0.4 * kSigma);
  // What `predict` states of new readings, four standard deviations of it to either side: not the believed model's
  // scatter.
  const std::optional<double> of_predicted = diagnosis.final.problem->experiment().noise.sigma;
  ASSERT_TRUE(of_predicted.has_value());
  EXPECT_NEAR(*of_predicted, kSigma, 0.32 * kSigma);
}

// Asked for, too, it removes nothing from what has a name.
TEST(Diagnosis, AskedRepeatabilityLeavesEffectsTheirNames) {
  CalibrationProblem problem = Hidden(2, [](double q) { return 80e-6 * std::cos(2 * q) - 50e-6 * std::sin(2 * q); });
  for (Observation& observation : problem.mutable_data()->observations) observation.sigma.setZero();
  problem.mutable_experiment()->noise.from = NoiseSpec::From::kVarianceComponents;
  problem.mutable_experiment()->repeatability.angle.estimate = true;
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  ASSERT_EQ(diagnosis.effects.size(), 1u);
  EXPECT_EQ(diagnosis.effects[0].candidate.spec.Path(), "effect/joint_harmonic[order=2]/A3");
}

TEST(Diagnosis, BumpOutsideTheCatalogueIsUnknown) {
  const auto bump = [](double q) { return 300e-6 * std::exp(-0.5 * std::pow((q - 0.3) / 0.15, 2)); };
  const Diagnosis diagnosis = Diagnose(Hidden(4, bump), DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kUnknown);
  EXPECT_EQ(diagnosis.unexplained.what.depends_on, std::vector<std::string>{"A3"});
  EXPECT_EQ(diagnosis.final_p, diagnosis.baseline_p);  // nothing was added
}

// Where nothing states sigma the baseline is what `calibrate` says, whatever the joints do, and a floor that is the
// model's own scatter closes no gap.
TEST(Diagnosis, WithoutASigmaTheBaselineIsThePlainFit) {
  CalibrationProblem problem = Hidden(2, [](double q) { return 300e-6 * std::cos(2 * q); });
  for (Observation& observation : problem.mutable_data()->observations) observation.sigma.setZero();
  const double plain = HoldoutRms(FitFully(problem, JointOptions()));
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_NEAR(HoldoutRms(diagnosis.baseline), plain, 1e-6 * plain);
  EXPECT_TRUE(std::isnan(diagnosis.gap.closed));
}

// Nor does the sigma that the rows were whitened by until their scatter was known: neither floor nor gap is.
TEST(Diagnosis, WithoutASigmaThereIsNoNoiseFloor) {
  const auto bump = [](double q) { return 300e-6 * std::exp(-0.5 * std::pow((q - 0.3) / 0.15, 2)); };
  CalibrationProblem problem = Hidden(4, bump);
  for (Observation& observation : problem.mutable_data()->observations) observation.sigma.setZero();
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  ASSERT_EQ(diagnosis.verdict, DiagnosisVerdict::kUnknown);
  for (const double figure : {diagnosis.gap.floor, diagnosis.gap.before, diagnosis.gap.after}) {
    EXPECT_TRUE(std::isnan(figure)) << figure;
  }
  const std::string text = DiagnosisToText(diagnosis);
  EXPECT_THAT(text, ::testing::HasSubstr("Gap on untouched configurations: not known, for nothing states the noise"));
  const nlohmann::ordered_json json = DiagnosisToJson(diagnosis, 0.01);
  for (const char* model : {"baseline", "final"}) {
    EXPECT_TRUE(json[model]["reduced_chi2"].is_null()) << json[model];
    EXPECT_TRUE(json[model]["lack_of_fit_p"].is_null()) << json[model];
  }
  for (const char* wrong : {"noise floor", "show no gap"}) EXPECT_EQ(text.find(wrong), std::string::npos) << text;
}

// A joint that jumps at 0.4 rad (22.9 deg): between two measured angles, which lie 3 deg apart on average. A3 is the
// third joint, and the formula is in urad over its degrees.
TEST(Diagnosis, WhatHasNoNameHasAFormula) {
  const auto jump = [](double q) { return q > 0.4 ? 300e-6 : 0.0; };
  const Diagnosis diagnosis = Diagnose(Hidden(4, jump), DiagnosisOptions());
  ASSERT_EQ(diagnosis.verdict, DiagnosisVerdict::kUnknown);
  EXPECT_EQ(diagnosis.unexplained.driver, "q3");
  const std::string& formula = diagnosis.unexplained.formula;
  double size = 0.0, at = 0.0;
  ASSERT_EQ(std::sscanf(formula.c_str(), "%lf·(q3 > %lf)", &size, &at), 2) << formula;
  EXPECT_NEAR(size, 300.0, 60.0) << formula;
  EXPECT_NEAR(at, 22.9, 10.0) << formula;
}

// It is learnt as a function of the joint's angle: on untouched rows little is left of it, and its shape is that of the
// bump (its mean is part of the joint's zero).
TEST(Diagnosis, WhatHasNoNameIsLearntAndPredicts) {
  const auto bump = [](double q) { return 300e-6 * std::exp(-0.5 * std::pow((q - 0.3) / 0.15, 2)); };
  const Diagnosis diagnosis = Diagnose(Hidden(4, bump), DiagnosisOptions());
  ASSERT_NE(diagnosis.learnt, nullptr);
  const LearntModel& learnt = *diagnosis.learnt;
  EXPECT_GT(learnt.gap.closed, 0.8);
  EXPECT_LT(HoldoutRms(learnt.model), 0.6 * HoldoutRms(diagnosis.final));
  // What it corrects is the nominal robot, as aligned before anything was fitted, and nothing was learnt of that.
  const ParameterSet& aligned = learnt.model.estimate.aligned;
  for (int i = 0; i < aligned.num_coordinates(); ++i) {
    const int own = diagnosis.baseline.estimate.aligned.FindCoordinate(aligned.coordinates()[i].name);
    EXPECT_EQ(aligned.Value(i), own < 0 ? 0.0 : diagnosis.baseline.estimate.aligned.Value(own))
        << aligned.coordinates()[i].name;
  }
  // Predictions allow for what it does not follow.
  Estimate estimate = learnt.model.estimate;
  const Trust judged = JudgeByHoldout(*learnt.model.problem, &estimate);
  const double scale = estimate.sigma.scaled ? std::max(1.0, estimate.sigma.a_posteriori) : 1.0;  // of what is stated
  const double distance = judged.holdout.distance_rms, predicted = judged.holdout.predicted_rms / scale;
  ASSERT_GT(predicted, 0.0);
  const double scatter = 3.0 * predicted * predicted * (1.0 - judged.holdout.parameters_share);
  const double rest = std::sqrt(std::max(0.0, distance * distance - scatter));
  EXPECT_GT(rest, 0.0);
  const nlohmann::ordered_json json = LearntEstimateToJson(diagnosis, {});
  EXPECT_NEAR(json.at("model_error").at("rest_mm").get<double>(), 1e3 * rest, 1e-9);
  EXPECT_TRUE(json.at("parameters").at(0).contains("sigma_noise_only"));
  const auto value = [&](double q) {
    double sum = 0.0;
    for (const EffectSpec& function : learnt.functions) {  // bumps of several widths
      EXPECT_EQ(function.effect, "learnt_deviation");
      EXPECT_EQ(function.target, "A3");
      EXPECT_EQ(function.settings.at("driver"), "A3");
      const double from = function.NumberSetting("from", 0.0) * kDegree,
                   to = function.NumberSetting("to", 0.0) * kDegree;
      const size_t count = static_cast<size_t>(function.IntegerSetting("knots", 0));
      EXPECT_EQ(function.values.size(), count);
      for (size_t k = 0; k < count; ++k) {
        const double apart = (to - from) / (count - 1.0), off = (q - from - k * apart) / apart;
        sum += function.values[k] * std::pow(kPi, -0.25) * std::exp(-0.5 * off * off);
      }
    }
    return sum;
  };
  EXPECT_NEAR(value(0.3) - 0.5 * (value(-0.3) + value(0.9)), 300e-6, 75e-6);
}

// Where nothing without a name is left, nothing is learnt.
TEST(Diagnosis, WhatHasANameIsNotLearnt) {
  const Diagnosis diagnosis = Diagnose(Hidden(2, [](double q) { return 200e-6 * std::cos(2.0 * q); }), {});
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kExplained);
  EXPECT_EQ(diagnosis.learnt, nullptr);
}

// A cause with a name on joint 5, with a ripple that has none, together with a larger one without a name on joint 1:
// the ripple makes a smooth function of joint 5 fit better than the gain alone, which holds all the same.
TEST(Diagnosis, NamedCauseHoldsBesideOneWithoutAName) {
  const auto bump = [](double q) { return 300e-6 * std::exp(-0.5 * std::pow((q - 0.3) / 0.15, 2)); };
  const auto gain = [](double q) { return 90e-6 * q + 25e-6 * std::sin(9.0 * q) * std::exp(-q * q); };
  const CalibrationProblem problem = Moved(6, [&](Eigen::VectorXd* q) {
    (*q)[0] += bump((*q)[0]);
    (*q)[4] += gain((*q)[4]);
  });
  const Diagnosis diagnosis = Diagnose(problem, DiagnosisOptions());
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kPartly);
  ASSERT_FALSE(diagnosis.effects.empty());
  EXPECT_EQ(diagnosis.effects[0].candidate.spec.Path(), "effect/encoder_gain/A5");
  for (const FoundEffect& effect : diagnosis.effects) EXPECT_NE(effect.candidate.spec.target, "A1");
}

}  // namespace
}  // namespace sagitta::diagnosis_test
