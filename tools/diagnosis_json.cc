#include "tools/diagnosis_json.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "models/effects/catalogue.h"
#include "problems/io/effect_entries.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kListedCandidates = 40;

Json Finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string Short(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

Json SettingsToJson(const EffectSpec& spec) {
  Json json = Json::object();
  for (const auto& [name, text] : spec.settings) {
    if (name == "order") {
      json[name] = std::stoi(text);
    } else if (name == "after_s") {
      json[name] = std::stod(text);
    } else {
      json[name] = text;
    }
  }
  return json;
}

Json SpecToJson(const EffectSpec& spec) {
  return {{"effect", spec.effect}, {"target", spec.target}, {"settings", SettingsToJson(spec)}};
}

std::string SettingsInWords(const EffectSpec& spec) {
  std::string words;
  for (const auto& [name, text] : spec.settings) words += ", " + name + " " + text;
  return words;
}

std::string Title(const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(spec.effect);
  const std::string title = definition == nullptr ? "gravity compensator" : definition->title;
  return title + " (" + spec.effect + ", " + spec.target + SettingsInWords(spec) + ")";
}

// Largest size that a healthy machine could show, in units of results.
bool IsPlausible(const DiagnosisStep& step) {
  for (const ParameterEstimate& row : step.parameters) {
    const bool is_compliance = row.quantity == Quantity::kCompliance;
    if (is_compliance && row.ci95.high < 0.0) return false;
    if (std::abs(row.value) > 5.0 * TraitsOf(row.quantity).hold_limit) return false;
    if (row.quantity == Quantity::kMass && row.ci95.high < 0.0 && step.chosen.candidate.spec.effect == "link_gravity")
      return false;
  }
  return true;
}

std::string SeparateBy(const EffectSpec& spec) {
  if (spec.effect == "gravity_compensator" || spec.effect == "link_gravity" || spec.effect == "self_weight_sag") {
    return "poses with " + spec.target +
           " over its whole range, loaded and unloaded, and with the links beyond it folded and stretched";
  }
  if (spec.effect == "joint_harmonic" || spec.effect == "encoder_gain" || spec.effect == "axis_wobble") {
    return "poses with " + spec.target + " evenly over its whole range, the other joints independent of it";
  }
  if (FindEffect(spec.effect)->target == EffectTarget::kStation || spec.effect == "joint_slip" ||
      spec.effect == "marker_shift") {
    return "the first poses repeated at the end, time columns";
  }
  if (spec.effect == "backlash") return "the same poses approached from both sides";
  return "loads in other directions: sideways pulls and other load points";
}

Json StepToJson(const DiagnosisStep& step) {
  Json json = SpecToJson(step.chosen.candidate.spec);
  json["p_value"] = step.chosen.corrected_p;
  json["chi2_reduction"] = step.chosen.reduction;
  json["parameters"] = Json::array();
  for (const ParameterEstimate& row : step.parameters) {
    const double unit = TraitsOf(row.quantity).si_per_unit;
    const std::string name = row.name.substr(row.name.rfind('/') + 1);
    json["parameters"].push_back({{"name", ParameterKey(name, row.quantity)},
                                  {"value", row.value / unit},
                                  {"sigma", row.sigma / unit},
                                  {"ci95", {row.ci95.low / unit, row.ci95.high / unit}}});
  }
  json["holdout_rms_before_mm"] = 1e3 * step.holdout_before;
  json["holdout_rms_after_mm"] = 1e3 * step.holdout_after;
  json["reduced_chi2_after"] = step.reduced_chi2_after;
  const bool plausible = IsPlausible(step);
  json["physical"] = {{"plausible", plausible},
                      {"words", plausible ? "the size is one that machines show"
                                          : "sign or size is not physical: take it as a description, not as a cause"}};
  json["alternatives"] = Json::array();
  for (const Alternative& alternative : step.alternatives) {
    Json entry = SpecToJson(alternative.spec);
    entry["overlap"] = alternative.overlap;
    entry["words"] = Title(alternative.spec) + " would explain " + Short(100 * alternative.overlap) + " % of it" +
                     (alternative.tied ? "; the data cannot tell the two apart" : "");
    entry["separate_by"] = SeparateBy(alternative.spec);
    json["alternatives"].push_back(entry);
  }
  json["words"] = StepInWords(step);
  return json;
}

Json NoiseToJson(const NoiseFinding& noise) {
  Json json = {{"scale", noise.scale}, {"ci95", {noise.low, noise.high}}};
  json["repeatability_urad"] = noise.repeatability > 0.0 ? Json(1e6 * noise.repeatability) : Json(nullptr);
  if (noise.repeatability > 0.0) {
    json["repeatability_ci95_urad"] = {1e6 * noise.repeatability_low, 1e6 * noise.repeatability_high};
  }
  json["outliers"] = noise.outliers;
  std::string words;
  if (noise.is_finding && std::abs(noise.scale - 1.0) > 0.02 && (noise.low > 1.0 || noise.high < 1.0)) {
    words += "The instrument's noise is " + Short(noise.scale) + " times what is stated. ";
  }
  if (noise.repeatability > 0.0) {
    words += "Joint repeatability of about " + Short(1e6 * noise.repeatability) + " urad was not declared. ";
  }
  if (!noise.outliers.empty()) words += std::to_string(noise.outliers.size()) + " outlier(s) were left out. ";
  json["words"] = words.empty() ? "The noise is as stated." : words;
  return json;
}

std::string VerdictInWords(const Diagnosis& d) {
  if (d.verdict == "consistent") return "Nothing is missing at this significance.";
  if (d.verdict == "noise") return "No effect is missing; the stated noise is wrong.";
  std::string names;
  for (const DiagnosisStep& step : d.steps) names += (names.empty() ? "" : "; ") + Title(step.chosen.candidate.spec);
  if (d.verdict == "explained") return "Found: " + names + ". Nothing significant is left.";
  if (d.verdict == "partly") return "Found: " + names + ". A significant rest has no name in the catalogue.";
  return "There is a significant gap that no effect of the catalogue explains well.";
}

std::string KindOf(const Decoy& decoy) { return decoy.kind.empty() ? "other" : decoy.kind; }

}  // namespace

std::string StepInWords(const DiagnosisStep& step) {
  std::string words = Title(step.chosen.candidate.spec) + ":";
  for (const ParameterEstimate& row : step.parameters) {
    const double unit = TraitsOf(row.quantity).si_per_unit;
    words += " " + row.name.substr(row.name.rfind('/') + 1) + " " + Short(row.value / unit) + " ± " +
             Short(0.5 * (row.ci95.high - row.ci95.low) / unit) + " " + TraitsOf(row.quantity).unit + ",";
  }
  words.back() = ';';
  words += " hold-out RMS " + Short(1e3 * step.holdout_before) + " -> " + Short(1e3 * step.holdout_after) + " mm.";
  if (step.chosen.candidate.spec.effect == "backlash") words += " Friction wind-up has the same signature.";
  return words;
}

Robot ExtendedRobot(const Diagnosis& diagnosis) {
  Robot robot = diagnosis.final.problem->model.WithValues(diagnosis.final.estimate.parameters.ModelValues());
  std::vector<EffectSpec> others;
  for (const EffectSpec& spec : robot.effects) {
    if (spec.effect != "joint_compliance") {
      others.push_back(spec);
      continue;
    }
    const int joint = robot.chain.FindJoint(spec.target);
    const auto own = std::find_if(robot.compliances.begin(), robot.compliances.end(),
                                  [&](const JointCompliance& c) { return c.joint == joint; });
    if (own == robot.compliances.end()) {
      robot.compliances.push_back({joint, {{0.0, spec.values[0]}}, false});
    } else {
      for (JointCompliance::Node& node : own->nodes) node.k += spec.values[0];
    }
  }
  robot.effects = others;
  return robot;
}

Json DiagnosisToJson(const Diagnosis& d, double significance) {
  const Estimate& before = d.baseline.estimate;
  const Estimate& after = d.final.estimate;
  Json json = {{"schema", "sagitta/diagnosis/1"}, {"verdict", d.verdict}, {"significance", significance}};
  json["words"] = VerdictInWords(d);
  json["baseline"] = {{"reduced_chi2", before.chi2 / std::max(1, before.dof)},
                      {"lack_of_fit_p", Finite(d.baseline_p)},
                      {"rms_mm", 1e3 * before.fit.rms},
                      {"holdout_rms_mm", 1e3 * before.validation.rms},
                      {"holdout_distance_rms_mm", 1e3 * before.validation.distance_rms}};
  json["where"] = Json::array();
  for (const WhereShare& share : d.where) {
    json["where"].push_back(
        {{"by", share.by},
         {"key", share.key},
         {"share_of_excess", share.share},
         {"words", Short(100 * share.share) + " % of the excess is at " + share.by + " " + share.key}});
  }
  json["noise"] = NoiseToJson(d.noise);
  json["candidates"] = Json::array();
  for (size_t i = 0; i < std::min(kListedCandidates, d.candidates.size()); ++i) {
    const ScreenedCandidate& candidate = d.candidates[i];
    if (candidate.score.rank == 0) continue;
    Json entry = SpecToJson(candidate.candidate.spec);
    entry["score"] = candidate.score.reduction;
    entry["p_value"] = candidate.corrected_p;
    entry["penalised"] = candidate.score.penalised;
    json["candidates"].push_back(entry);
  }
  json["not_testable"] = Json::array();
  for (const NotTestable& entry : d.not_testable) {
    json["not_testable"].push_back({{"effect", entry.effect}, {"target", entry.target}, {"needs", entry.needs}});
  }
  json["steps"] = Json::array();
  for (const DiagnosisStep& step : d.steps) json["steps"].push_back(StepToJson(step));
  json["final"] = {{"reduced_chi2", after.chi2 / std::max(1, after.dof)},
                   {"lack_of_fit_p", Finite(d.final_p)},
                   {"rms_mm", 1e3 * after.fit.rms},
                   {"holdout_rms_mm", 1e3 * after.validation.rms},
                   {"holdout_distance_rms_mm", 1e3 * after.validation.distance_rms},
                   {"noise_floor_mm", 1e3 * after.noise_floor},
                   {"gap_before_mm", 1e3 * d.gap.before},
                   {"gap_after_mm", 1e3 * d.gap.after},
                   {"gap_closed", d.gap.closed},
                   {"gap_closed_ci95", {d.gap.closed_ci95.low, d.gap.closed_ci95.high}}};
  json["unexplained"] = nullptr;
  if (d.verdict == "unknown" || d.verdict == "partly") {
    const Json depends = d.unexplained.depends_on;
    json["unexplained"] = {
        {"words", d.unexplained.words.empty() ? "no driving variable stands out" : d.unexplained.words},
        {"depends_on", depends},
        {"kind", KindOf(d.unexplained)}};
  }
  return json;
}

std::string DiagnosisToText(const Diagnosis& d) {
  std::ostringstream text;
  const Estimate& before = d.baseline.estimate;
  const Estimate& after = d.final.estimate;
  text << "Verdict: " << d.verdict << ". " << VerdictInWords(d) << "\n\n";
  text << "Baseline: reduced chi-square " << Short(before.chi2 / std::max(1, before.dof)) << ", hold-out RMS "
       << Short(1e3 * before.validation.rms) << " mm\n";
  for (size_t i = 0; i < d.steps.size(); ++i) {
    text << "Step " << i + 1 << ": " << StepInWords(d.steps[i]) << "\n";
    for (const Alternative& alternative : d.steps[i].alternatives) {
      text << "    or " << Title(alternative.spec) << " (overlap " << Short(alternative.overlap) << "); separate by "
           << SeparateBy(alternative.spec) << "\n";
    }
  }
  text << "Final: reduced chi-square " << Short(after.chi2 / std::max(1, after.dof)) << ", hold-out RMS "
       << Short(1e3 * after.validation.rms) << " mm, noise floor " << Short(1e3 * after.noise_floor) << " mm\n";
  text << "Gap on untouched configurations: " << Short(1e3 * d.gap.before) << " -> " << Short(1e3 * d.gap.after)
       << " mm, closed " << Short(100 * d.gap.closed) << " %\n";
  text << "Noise: " << NoiseToJson(d.noise)["words"].get<std::string>() << "\n";
  if (d.has_unexplained) text << "Unexplained: " << d.unexplained.words << "\n";
  return text.str();
}

}  // namespace sagitta
