#include "estimator/diagnosis/scanned_settings.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/refit_order.h"
#include "models/effects/catalogue.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Steps, equal in the logarithm: a quarter of a step that leaves 1 - 0.95^2 of a chi-square leaves a sixteenth of that,
// and the parabola through three of them less than is in doubt.
constexpr int kBetweenListed = 4;
constexpr double kSameSetting = 1e-6;  // relative
constexpr int kDigits = 3;  // of a setting that is found: no rows determine a time constant or a width to 0.5 %

const SettingDefinition* ScannedDefinition(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition == nullptr) return nullptr;
  for (const SettingDefinition& setting : definition->settings) {
    if (setting.kind == SettingDefinition::Kind::kNumber && !setting.choices.empty() &&
        spec.settings.count(setting.name) > 0)
      return &setting;
  }
  return nullptr;
}

// What is listed, and one more on either side as far from the last as that from the one before.
std::vector<double> ListedValues(const SettingDefinition& setting) {
  std::vector<double> values;
  for (const std::string& choice : setting.choices) values.push_back(std::stod(choice));
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  if (n < 2) return values;
  const double below = values[0] * values[0] / values[1], above = values[n - 1] * values[n - 1] / values[n - 2];
  values.insert(values.begin(), below);
  values.push_back(above);
  return values;
}

// The values, and between each two of them others, equally far apart in the logarithm.
std::vector<double> WithBetween(const std::vector<double>& values) {
  std::vector<double> all;
  for (size_t i = 0; i + 1 < values.size(); ++i) {
    const double step = std::log(values[i + 1] / values[i]) / kBetweenListed;
    for (int k = 0; k < kBetweenListed; ++k) all.push_back(values[i] * std::exp(k * step));
  }
  all.push_back(values.back());
  return all;
}

// All of these, ascending, and the effect's own.
std::vector<double> ScanOf(const SettingDefinition& setting, double own) {
  std::vector<double> values = WithBetween(ListedValues(setting));
  const auto is_own = [own](double value) { return std::abs(value - own) < kSameSetting * own; };
  values.erase(std::remove_if(values.begin(), values.end(), is_own), values.end());
  values.insert(std::upper_bound(values.begin(), values.end(), own), own);
  return values;
}

EffectSpec At(EffectSpec spec, const std::string& setting, double value) {
  spec.settings[setting] = Significant(value, kDigits);
  return spec;
}

// Parameters are called by the effect with its settings.
void ChangeTo(const EffectSpec& changed, Candidate* candidate) {
  const size_t length = candidate->spec.Path().size();
  for (std::vector<std::string>* names : {&candidate->poorly_determined, &candidate->loose}) {
    for (std::string& name : *names) name.replace(0, length, changed.Path());
  }
  candidate->spec = changed;
}

// The model refitted at each value; without those where it does not converge.
std::vector<FitAt> FitSettings(const DiagnosedModel& model, const EffectSpec& spec, const std::string& setting,
                               const std::vector<double>& values) {
  std::vector<FitAt> fits;
  for (const double value : values) {
    const EffectSpec changed = At(spec, setting, value);
    const bool is_own = value == spec.NumberSetting(setting, 0.0);
    const DiagnosedModel other = WithInstead(model, spec, is_own ? spec : changed);
    QuickRefit refit = RefitQuickly(*other.problem, other.estimate.parameters);
    if (IsUsable(refit.estimate.status)) fits.push_back({value, is_own ? spec : changed, std::move(refit)});
  }
  return fits;
}

// Where the parabola through the best fit and its neighbours, in the logarithm of the number, is least.
double LeastOf(const std::vector<FitAt>& fits) {
  const size_t best = static_cast<size_t>(&BestOf(fits) - fits.data());
  if (best == 0 || best + 1 == fits.size()) return fits[best].at;
  const double left = std::log(fits[best - 1].at / fits[best].at), right = std::log(fits[best + 1].at / fits[best].at);
  const double a = (fits[best - 1].chi2() - fits[best].chi2()) / left;
  const double b = (fits[best + 1].chi2() - fits[best].chi2()) / right;
  const double curvature = (b - a) / (right - left);  // a = slope + curvature left, b = slope + curvature right
  if (!(curvature > 0.0)) return fits[best].at;
  return fits[best].at * std::exp(-0.5 * (a - curvature * left) / curvature);
}

}  // namespace

double TuneSettings(const Evidence& evidence, const JointOptions& joint, RefittedSet* refitted) {
  if (!refitted->IsUsable()) return 0.0;
  double gain = 0.0;
  for (size_t k = 0; k < refitted->effects.size(); ++k) {
    const EffectSpec spec = refitted->effects[k].candidate.spec;
    const SettingDefinition* setting = ScannedDefinition(evidence.robot(), spec);
    if (setting == nullptr) continue;
    const double own = spec.NumberSetting(setting->name, 0.0);
    const std::vector<FitAt> fits = FitSettings(refitted->with_effects, spec, setting->name, ScanOf(*setting, own));
    if (fits.empty()) continue;
    RefittedSet tuned = *refitted;
    ChangeTo(At(spec, setting->name, LeastOf(fits)), &tuned.effects[k].candidate);
    tuned.with_effects = Extend(tuned.lacking, CandidatesOf(tuned.effects), joint);
    if (!tuned.IsUsable()) continue;
    const double better = LogFullOverLinear(evidence, tuned) - LogFullOverLinear(evidence, *refitted);
    VLOG(1) << "diagnosis: " << tuned.effects[k].candidate.spec.Path() << " in place of " << spec.Path() << " adds "
            << better << " to the log likelihood";
    if (better < kInDoubt) continue;
    gain += better;
    *refitted = std::move(tuned);
  }
  return gain;
}

void AllowForSetting(const DiagnosedModel& final, const EffectSpec& spec, std::vector<ParameterEstimate>* rows) {
  const SettingDefinition* setting = ScannedDefinition(final.problem->robot(), spec);
  if (setting == nullptr) return;
  const double own = spec.NumberSetting(setting->name, 0.0);
  const std::vector<FitAt> fits = FitSettings(final, spec, setting->name, ScanOf(*setting, own));
  if (fits.empty()) return;
  for (ParameterEstimate& row : *rows) Widen(fits, own, spec, &row);
}

}  // namespace sagitta
