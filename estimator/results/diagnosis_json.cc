#include "estimator/results/diagnosis_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/diagnosis/learnt_model.h"
#include "estimator/report/diagnosis_caution_words.h"
#include "estimator/report/diagnosis_next_words.h"
#include "estimator/report/diagnosis_noise_words.h"
#include "estimator/report/diagnosis_words.h"
#include "estimator/results/json_numbers.h"
#include "problems/compliance_home.h"
#include "problems/io/effect_entries.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kListedCandidates = 40;
constexpr double kHardlyWorthALine = 1e-4;  // of probability

// mm; null without a hold-out.
Json HeldOut(const Estimate& estimate, double metres) {
  return estimate.validation.observations > 0 ? Finite(1e3 * metres) : Json(nullptr);
}

Json SpecToJson(const Robot& robot, const EffectSpec& spec) {
  return {{"effect", spec.effect}, {"target", spec.target}, {"settings", SettingsToJson(robot, spec)}};
}

Json HalvesToJson(const Confirmation& confirmation) {
  Json json = {{"probability", Json::array()}, {"best", Json::array()}};
  for (const HalfResult& half : confirmation.halves) {
    json["probability"].push_back(half.probability);
    json["best"].push_back(half.best);
  }
  json["compatible_p"] = Finite(confirmation.compatible_p);
  json["words"] = HalvesInWords(confirmation);
  return json;
}

// Where nothing states the noise, the scatter about each model is its own unit: figures in it compare nothing.
Json OnStatedNoise(const Diagnosis& d, double figure) { return d.noise.is_stated ? Finite(figure) : Json(nullptr); }

void PossibleToJson(const PossibleNumbers& numbers, Json* step) {
  if (numbers.is_thermal_lag) {
    (*step)["thermal_lag_s"] = {{"best", numbers.best}, {"possible", {numbers.least, numbers.most}}};
    return;
  }
  const Json least = numbers.is_open_below ? Json(nullptr) : Json(numbers.least);
  const Json most = numbers.is_open_above ? Json(nullptr) : Json(numbers.most);
  (*step)["settings_ci95"] = {{numbers.setting, {least, most}}};
}

Json FoundToJson(const Diagnosis& d, const FoundEffect& effect) {
  const Robot& robot = d.final.problem->robot();
  Json json = SpecToJson(robot, effect.candidate.spec);
  json["probability"] = effect.probability;
  json["p_value"] = effect.corrected_p;
  json["chi2_reduction"] = effect.reduction;
  json["parameters"] = Json::array();
  for (const ParameterEstimate& row : effect.parameters) {
    const double unit = TraitsOf(row.quantity).si_per_unit;
    const std::string name = row.name.substr(row.name.rfind('/') + 1);
    json["parameters"].push_back({{"name", ParameterKey(name, row.quantity)},
                                  {"value", row.value / unit},
                                  {"sigma", row.sigma / unit},
                                  {"ci95", {row.ci95.low / unit, row.ci95.high / unit}},
                                  {"identifiable", IsDetermined(effect, row)}});
  }
  if (effect.numbers) PossibleToJson(*effect.numbers, &json);
  json["holdout_rms_before_mm"] = Finite(1e3 * effect.holdout_before);
  json["holdout_rms_after_mm"] = Finite(1e3 * effect.holdout_after);
  json["reduced_chi2_after"] = OnStatedNoise(d, effect.reduced_chi2_after);
  json["halves"] = HalvesToJson(effect.confirmation);
  json["physical"] = {{"plausible", effect.bounds.IsPlausible()}, {"words", PhysicalInWords(effect.bounds)}};
  json["alternatives"] = Json::array();
  for (const Alternative& alternative : effect.alternatives) {
    Json entry = SpecToJson(robot, alternative.spec);
    entry["probability"] = alternative.probability;
    entry["overlap"] = alternative.overlap;
    entry["words"] = AlternativeInWords(robot, alternative);
    entry["separate_by"] = SeparateBy(robot, alternative);
    json["alternatives"].push_back(entry);
  }
  json["words"] = EffectInWords(robot, effect);
  return json;
}

Json PosteriorToJson(const Robot& robot, const ReportedPosterior& posterior) {
  Json json = {{"nothing", posterior.nothing}, {"noise", posterior.noise}, {"unnamed", posterior.unnamed}};
  json["explanations"] = Json::array();
  for (const auto& [spec, probability] : posterior.explanations) {
    if (probability < kHardlyWorthALine) break;
    Json entry = SpecToJson(robot, spec);
    entry["probability"] = probability;
    json["explanations"].push_back(entry);
  }
  return json;
}

// Most probable first; nothing missing is a set without explanations.
Json SetsToJson(const Robot& robot, const ReportedPosterior& posterior) {
  std::vector<Json> sets = {{{"probability", posterior.nothing + posterior.noise}, {"explanations", Json::array()}}};
  for (const NamedSet& set : posterior.sets) {
    Json entry = {{"probability", set.probability}, {"explanations", Json::array()}};
    for (const EffectSpec& spec : set.specs) entry["explanations"].push_back(SpecToJson(robot, spec));
    if (!set.unnamed.empty()) entry["unnamed"] = set.unnamed;
    sets.push_back(entry);
  }
  const auto probability = [](const Json& set) { return set["probability"].get<double>(); };
  std::stable_sort(sets.begin(), sets.end(),
                   [&](const Json& a, const Json& b) { return probability(a) > probability(b); });
  Json json = Json::array();
  for (Json& set : sets) json.push_back(std::move(set));
  return json;
}

Json PriorToJson(const Robot& robot, const ReportedPosterior& posterior) {
  const PriorMasses& prior = posterior.prior;
  Json json = {{"nothing", prior.nothing},
               {"catalogue", prior.catalogue},
               {"unnamed", prior.unnamed},
               {"further", prior.further},
               {"noise_wrong", kNoiseIsWrong}};
  json["flips"] = Json::array();
  for (const ReportedFlip& flip : posterior.flips) json["flips"].push_back(FlipInWords(robot, flip));
  return json;
}

Json GroupsToJson(const Diagnosis& d) {
  Json json = Json::array();
  for (const EffectGroup& group : d.groups) {
    json.push_back({{"words", GroupInWords(d, group)},
                    {"steps", group.effects},
                    {"probability", Finite(group.probability)},
                    {"share_of_gap", Finite(group.share_of_gap)}});
  }
  return json;
}

Json ClosedToJson(const GapReport& gap) {
  if (!std::isfinite(gap.closed_ci95.low)) return nullptr;
  return {gap.closed_ci95.low, gap.closed_ci95.high};
}

Json LearntToJson(const Robot& robot, const LearntModel& learnt) {
  Json functions = Json::array();
  for (const EffectSpec& spec : learnt.functions) functions.push_back(SpecToJson(robot, spec));
  const Estimate& after = learnt.model.estimate;
  return {{"functions", functions},
          {"file", kLearntFile},
          {"holdout_rms_mm", HeldOut(after, after.validation.rms)},
          {"gap_closed", Finite(learnt.gap.closed)},
          {"gap_closed_ci95", ClosedToJson(learnt.gap)}};
}

Json UnexplainedToJson(const Diagnosis& d) {
  const LearntFunction& learnt = d.unexplained;
  Json json = {{"words", UnexplainedInWords(d)}, {"depends_on", learnt.what.depends_on}, {"kind", learnt.what.kind}};
  json["learnt"] = nullptr;
  if (d.learnt) json["learnt"] = LearntToJson(d.final.problem->robot(), *d.learnt);
  json["function"] = nullptr;
  if (learnt.table.empty()) return json;
  Json table = Json::array();
  for (const FunctionPoint& point : learnt.table) table.push_back({point.at, point.value, point.sigma});
  json["function"] = {{"acts_on", learnt.what.acts_on},
                      {"driver", learnt.driver},
                      {"driver_words", learnt.what.driver.name},
                      {"driver_unit", learnt.what.driver.unit},
                      {"unit", learnt.unit},
                      {"table", table},
                      {"formula", learnt.formula},
                      {"words", learnt.words}};
  return json;
}

Json NoiseToJson(const NoiseFinding& noise) {
  Json json = {{"scale", noise.scale}, {"ci95", {Finite(noise.low), Finite(noise.high)}}};
  json["repeatability_urad"] = nullptr;
  const auto add = [&](const FoundRepeatability& found, const std::string& micro) {
    if (!(found.sigma > 0.0)) return;
    json["repeatability_" + micro] = 1e6 * found.sigma;
    json["repeatability_ci95_" + micro] = {nullptr, nullptr};
    if (found.HasInterval()) json["repeatability_ci95_" + micro] = {1e6 * found.low, 1e6 * found.high};
  };
  add(noise.turn, "urad");
  add(noise.travel, "um");
  json["outliers"] = noise.outliers;
  for (const WrongArrival& arrival : noise.arrivals) {
    json["wrong_configs"].push_back({{"config", arrival.configuration}, {"off_mm", 1e3 * arrival.off}});
  }
  for (const GroupFinding& group : noise.groups) {
    json["groups"].push_back({{"of", WordOf(group.kind)},
                              {"name", group.name.empty() ? Json(nullptr) : Json(group.name)},
                              {"factor", group.factor},
                              {"ci95", {group.low, group.high}}});
  }
  if (noise.repeatability_is_overstated) json["repeatability_is_overstated"] = true;
  if (noise.is_bound) json["is_bound"] = true;
  json["probability"] = noise.probability;
  json["words"] = NoiseInWords(noise);
  return json;
}

Json CandidatesToJson(const Diagnosis& d) {
  Json json = Json::array();
  for (size_t i = 0; i < std::min(kListedCandidates, d.candidates.size()); ++i) {
    const ScreenedCandidate& candidate = d.candidates[i];
    Json entry = SpecToJson(d.final.problem->robot(), candidate.spec);
    entry["score"] = candidate.reduction;
    entry["p_value"] = candidate.corrected_p;
    entry["log_evidence"] = candidate.log_evidence;
    entry["holdout_rms_mm"] = candidate.holdout_rms ? Json(1e3 * *candidate.holdout_rms) : Json(nullptr);
    json.push_back(entry);
  }
  return json;
}

Json FinalToJson(const Diagnosis& d) {
  const Estimate& after = d.final.estimate;
  Json json = {{"reduced_chi2", OnStatedNoise(d, after.chi2 / std::max(1, after.dof))},
               {"lack_of_fit_p", OnStatedNoise(d, d.final_p)},
               {"rms_mm", 1e3 * after.fit.rms},
               {"holdout_rms_mm", HeldOut(after, after.validation.rms)},
               {"holdout_distance_rms_mm", HeldOut(after, after.validation.distance_rms)},
               {"noise_floor_mm", HeldOut(after, d.gap.floor)},
               {"gap_before_mm", Finite(1e3 * d.gap.before)},
               {"gap_after_mm", Finite(1e3 * d.gap.after)},
               {"gap_closed", Finite(d.gap.closed)}};
  json["gap_closed_ci95"] = ClosedToJson(d.gap);
  return json;
}

}  // namespace

Robot RobotOf(const DiagnosedModel& model) {
  Robot robot = model.problem->RobotWith(model.estimate.parameters);
  MoveCompliancesHome(PriorOfCompliance::kIsDropped, &robot);
  return robot;
}

Json DiagnosisToJson(const Diagnosis& d, double significance) {
  const Estimate& before = d.baseline.estimate;
  const Robot& robot = d.final.problem->robot();
  Json json = {{"schema", "sagitta/diagnosis/1"}, {"verdict", WordOf(d.verdict)}, {"significance", significance}};
  json["words"] = VerdictInWords(d);
  if (!d.cautions.empty()) json["cautions"] = d.cautions;
  const std::vector<std::string>& warnings = d.baseline.problem->data().warnings;
  if (!warnings.empty()) json["warnings"] = warnings;
  json["baseline"] = {{"reduced_chi2", OnStatedNoise(d, before.chi2 / std::max(1, before.dof))},
                      {"lack_of_fit_p", OnStatedNoise(d, d.baseline_p)},
                      {"rms_mm", 1e3 * before.fit.rms},
                      {"holdout_rms_mm", HeldOut(before, before.validation.rms)},
                      {"holdout_distance_rms_mm", HeldOut(before, before.validation.distance_rms)}};
  json["where"] = Json::array();
  for (const WhereShare& share : d.where) {
    json["where"].push_back(
        {{"by", share.by}, {"key", share.key}, {"share_of_excess", share.share}, {"words", ShareInWords(share)}});
  }
  json["noise"] = NoiseToJson(d.noise);
  json["screened"] = d.screened;
  json["candidates"] = CandidatesToJson(d);
  json["not_testable"] = Json::array();
  for (const NotTestable& entry : d.not_testable) {
    json["not_testable"].push_back({{"effect", entry.effect}, {"target", entry.target}, {"needs", entry.needs}});
  }
  json["steps"] = Json::array();
  for (const FoundEffect& effect : d.effects) json["steps"].push_back(FoundToJson(d, effect));
  json["final"] = FinalToJson(d);
  json["unexplained"] = nullptr;
  if (d.verdict == DiagnosisVerdict::kUnknown || d.verdict == DiagnosisVerdict::kPartly)
    json["unexplained"] = UnexplainedToJson(d);
  json["posterior"] = PosteriorToJson(robot, d.posterior);
  json["sets"] = SetsToJson(robot, d.posterior);
  json["prior"] = PriorToJson(robot, d.posterior);
  json["groups"] = GroupsToJson(d);
  json["next"] = nullptr;
  if (d.next) {
    json["next"] = {{"words", NextInWords(*d.baseline.problem, *d.next, d.verdict == DiagnosisVerdict::kConsistent)},
                    {"file", kNextFile},
                    {"decides", d.next->decides},
                    {"of_probability", Finite(d.next->of_probability)}};
    json["next"]["poses_for_90_percent"] = d.next->needed > 0 ? Json(d.next->needed) : Json();
  }
  return json;
}

}  // namespace sagitta
