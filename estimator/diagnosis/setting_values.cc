#include "estimator/diagnosis/setting_values.h"

#include <algorithm>
#include <cmath>

#include "models/effects/catalogue.h"
#include "problems/io/units.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Steps, equal in the logarithm: a quarter of a step that leaves 1 - 0.95^2 of a chi-square leaves a sixteenth of that,
// and the parabola through three of them less than is in doubt.
constexpr int kBetweenListed = 4;
constexpr double kSameSetting = 1e-6;  // relative: settings are written with seven digits (AsSetting)

constexpr int kDigits = 3;  // of a setting that is found: no rows determine a time constant or a width to 0.5 %

constexpr int kRounded = 3;  // times: 1 N m is the least width listed, and 1/27 of it is the friction of a seal

// What is listed, and one more on either side as far from the last as that from the one before.
std::vector<double> ListedValues(const SettingDefinition& setting) {
  std::vector<double> values;
  for (const std::string& choice : setting.choices) values.push_back(ParseNumber(choice).value());
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

}  // namespace

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

std::vector<double> ScanOf(const SettingDefinition& setting, double own) {
  std::vector<double> values = WithBetween(ListedValues(setting));
  const auto is_own = [own](double value) { return std::abs(value - own) < kSameSetting * own; };
  values.erase(std::remove_if(values.begin(), values.end(), is_own), values.end());
  values.insert(std::upper_bound(values.begin(), values.end(), own), own);
  return values;
}

EffectSpec At(EffectSpec spec, const std::string& setting, double value) {
  spec.settings[setting] = Significant(value, kDigits);
  if (value == 0.0) spec.settings.erase(setting);
  return spec;
}

void ChangeTo(const EffectSpec& changed, Candidate* candidate) {
  const size_t length = candidate->spec.Path().size();
  for (std::vector<std::string>* names : {&candidate->poorly_determined, &candidate->loose}) {
    for (std::string& name : *names) name.replace(0, length, changed.Path());
  }
  candidate->spec = changed;
}

std::vector<EffectSpec> Rounded(const Robot& robot, const EffectSpec& spec) {
  std::vector<EffectSpec> rounded;
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition == nullptr || definition->PressedByOf(spec) != PressedBy::kTorque) return rounded;
  for (const SettingDefinition& setting : definition->settings) {
    const bool is_width = setting.kind == SettingDefinition::Kind::kNumber && setting.MeansSomethingFor(spec);
    if (!is_width || setting.choices.empty() || spec.settings.count(setting.name) > 0) continue;
    double width = ListedValues(setting).front();
    for (int k = 0; k < kRounded; ++k, width /= 3.0) rounded.push_back(At(spec, setting.name, width));
  }
  return rounded;
}

}  // namespace sagitta
