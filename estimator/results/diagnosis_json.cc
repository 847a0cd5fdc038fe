#include "estimator/results/diagnosis_json.h"

#include <algorithm>
#include <cmath>

#include "problems/io/effect_entries.h"
#include "estimator/results/diagnosis_words.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kListedCandidates = 40;

Json Finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// mm; null without a hold-out.
Json HeldOut(const Estimate& estimate, double metres) {
  return estimate.validation.observations > 0 ? Json(1e3 * metres) : Json(nullptr);
}

Json SpecToJson(const Robot& robot, const EffectSpec& spec) {
  return {{"effect", spec.effect}, {"target", spec.target}, {"settings", SettingsToJson(robot, spec)}};
}

Json HalvesToJson(const Confirmation& confirmation) {
  Json json = {{"named_again", Json::array()}, {"best", Json::array()}};
  for (const HalfResult& half : confirmation.halves) {
    json["named_again"].push_back(half.named);
    json["best"].push_back(half.best);
  }
  json["compatible_p"] = Finite(confirmation.compatible_p);
  json["words"] = HalvesInWords(confirmation);
  return json;
}

Json StepToJson(const Robot& robot, const DiagnosisStep& step) {
  Json json = SpecToJson(robot, step.chosen.candidate.spec);
  json["p_value"] = step.chosen.corrected_p;
  json["chi2_reduction"] = step.chosen.reduction;
  json["parameters"] = Json::array();
  for (const ParameterEstimate& row : step.parameters) {
    const double unit = TraitsOf(row.quantity).si_per_unit;
    const std::string name = row.name.substr(row.name.rfind('/') + 1);
    json["parameters"].push_back({{"name", ParameterKey(name, row.quantity)},
                                  {"value", row.value / unit},
                                  {"sigma", row.sigma / unit},
                                  {"ci95", {row.ci95.low / unit, row.ci95.high / unit}},
                                  {"identifiable", IsTold(step, row)}});
  }
  if (step.lag) {
    json["thermal_lag_s"] = {{"best", step.lag->best}, {"possible", {step.lag->shortest, step.lag->longest}}};
  }
  json["holdout_rms_before_mm"] = Finite(1e3 * step.holdout_before);
  json["holdout_rms_after_mm"] = Finite(1e3 * step.holdout_after);
  json["reduced_chi2_after"] = Finite(step.reduced_chi2_after);
  json["cross_validation"] = {{"folds", step.confirmation.folds},
                              {"chi2_per_row_before", Finite(step.confirmation.cv_before)},
                              {"chi2_per_row_after", Finite(step.confirmation.cv_after)}};
  json["halves"] = HalvesToJson(step.confirmation);
  json["physical"] = {{"plausible", IsPlausible(robot, step)}, {"words", PhysicalInWords(robot, step)}};
  json["alternatives"] = Json::array();
  for (const Alternative& alternative : step.alternatives) {
    Json entry = SpecToJson(robot, alternative.spec);
    entry["overlap"] = alternative.overlap;
    entry["words"] = AlternativeInWords(robot, alternative);
    entry["separate_by"] = SeparateBy(robot, alternative.spec);
    json["alternatives"].push_back(entry);
  }
  json["words"] = StepInWords(robot, step);
  return json;
}

Json NoiseToJson(const NoiseFinding& noise) {
  Json json = {{"scale", noise.scale}, {"ci95", {Finite(noise.low), Finite(noise.high)}}};
  json["repeatability_urad"] = noise.repeatability > 0.0 ? Json(1e6 * noise.repeatability) : Json(nullptr);
  if (noise.repeatability > 0.0) {
    json["repeatability_ci95_urad"] = {1e6 * noise.repeatability_low, 1e6 * noise.repeatability_high};
  }
  json["outliers"] = noise.outliers;
  if (noise.repeatability_is_overstated) json["repeatability_is_overstated"] = true;
  if (noise.is_bound || noise.repeatability_is_bound) json["is_bound"] = true;
  json["words"] = NoiseInWords(noise);
  return json;
}

Json CandidatesToJson(const Diagnosis& d) {
  Json json = Json::array();
  for (size_t i = 0; i < std::min(kListedCandidates, d.candidates.size()); ++i) {
    const ScreenedCandidate& candidate = d.candidates[i];
    if (candidate.score.rank == 0) continue;
    Json entry = SpecToJson(d.final.problem->robot, candidate.candidate.spec);
    entry["score"] = candidate.score.reduction;
    entry["p_value"] = candidate.corrected_p;
    entry["penalised"] = candidate.score.penalised;
    entry["holdout_rms_mm"] = candidate.holdout_rms ? Json(1e3 * *candidate.holdout_rms) : Json(nullptr);
    json.push_back(entry);
  }
  return json;
}

Json FinalToJson(const Diagnosis& d) {
  const Estimate& after = d.final.estimate;
  Json json = {{"reduced_chi2", after.chi2 / std::max(1, after.dof)},
               {"lack_of_fit_p", Finite(d.final_p)},
               {"rms_mm", 1e3 * after.fit.rms},
               {"holdout_rms_mm", HeldOut(after, after.validation.rms)},
               {"holdout_distance_rms_mm", HeldOut(after, after.validation.distance_rms)},
               {"noise_floor_mm", HeldOut(after, after.noise_floor)},
               {"gap_before_mm", Finite(1e3 * d.gap.before)},
               {"gap_after_mm", Finite(1e3 * d.gap.after)},
               {"gap_closed", Finite(d.gap.closed)},
               {"gap_closed_ci95", nullptr}};
  if (std::isfinite(d.gap.closed_ci95.low)) {
    json["gap_closed_ci95"] = {d.gap.closed_ci95.low, d.gap.closed_ci95.high};
  }
  return json;
}

// Adds the compliance to that of the robot; not where that would be less than none, as beside a simulation that is
// softer than the arm.
bool MoveHome(const EffectSpec& spec, Robot* robot) {
  const int joint = robot->chain.FindJoint(spec.target);
  const auto own = std::find_if(robot->compliances.begin(), robot->compliances.end(),
                                [&](const JointCompliance& c) { return c.joint == joint; });
  std::vector<JointCompliance::Node> nodes = {{0.0, 0.0}};
  if (own != robot->compliances.end()) nodes = own->nodes;
  for (JointCompliance::Node& node : nodes) node.k += spec.values[0];
  if (std::any_of(nodes.begin(), nodes.end(), [](const JointCompliance::Node& node) { return node.k < 0.0; })) {
    return false;
  }
  if (own != robot->compliances.end()) {
    own->nodes = nodes;
  } else {
    robot->compliances.push_back({joint, nodes, false});
  }
  return true;
}

std::string KindOf(const Decoy& decoy) { return decoy.kind.empty() ? "other" : decoy.kind; }

}  // namespace

Robot ExtendedRobot(const Diagnosis& diagnosis) {
  Robot robot = diagnosis.final.problem->model.WithValues(diagnosis.final.estimate.parameters.ModelValues());
  std::vector<EffectSpec> others;
  for (const EffectSpec& spec : robot.effects) {
    if (spec.effect != "joint_compliance" || !MoveHome(spec, &robot)) others.push_back(spec);
  }
  robot.effects = others;
  return robot;
}

Json DiagnosisToJson(const Diagnosis& d, double significance) {
  const Estimate& before = d.baseline.estimate;
  Json json = {{"schema", "sagitta/diagnosis/1"}, {"verdict", d.verdict}, {"significance", significance}};
  json["words"] = VerdictInWords(d);
  if (!d.cautions.empty()) json["cautions"] = d.cautions;
  json["baseline"] = {{"reduced_chi2", before.chi2 / std::max(1, before.dof)},
                      {"lack_of_fit_p", Finite(d.baseline_p)},
                      {"rms_mm", 1e3 * before.fit.rms},
                      {"holdout_rms_mm", HeldOut(before, before.validation.rms)},
                      {"holdout_distance_rms_mm", HeldOut(before, before.validation.distance_rms)}};
  json["where"] = Json::array();
  for (const WhereShare& share : d.where) {
    json["where"].push_back(
        {{"by", share.by}, {"key", share.key}, {"share_of_excess", share.share}, {"words", ShareInWords(share)}});
  }
  json["noise"] = NoiseToJson(d.noise);
  json["screened"] = d.candidates.size();  // p-values are corrected for them all
  json["candidates"] = CandidatesToJson(d);
  json["not_testable"] = Json::array();
  for (const NotTestable& entry : d.not_testable) {
    json["not_testable"].push_back({{"effect", entry.effect}, {"target", entry.target}, {"needs", entry.needs}});
  }
  json["steps"] = Json::array();
  for (const DiagnosisStep& step : d.steps) json["steps"].push_back(StepToJson(d.final.problem->robot, step));
  json["final"] = FinalToJson(d);
  json["unexplained"] = nullptr;
  if (d.verdict == "unknown" || d.verdict == "partly") {
    const Json depends = d.unexplained.depends_on;
    json["unexplained"] = {
        {"words", UnexplainedInWords(d.unexplained)}, {"depends_on", depends}, {"kind", KindOf(d.unexplained)}};
  }
  return json;
}

}  // namespace sagitta
