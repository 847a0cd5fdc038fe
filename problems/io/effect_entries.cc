#include "problems/io/effect_entries.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "models/effects/catalogue.h"
#include "models/gravity_compensator.h"
#include "problems/calibration_problem.h"
#include "problems/input_error.h"
#include "problems/robot_structure.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kPriorSigma = "prior_sigma";

// Stations, loads and markers are known to the data only: checked there.
std::string ReadEffectTarget(const EffectDefinition& definition, const Robot& robot, YamlMap* map) {
  const std::string key = TargetKey(definition.target);
  if (key.empty()) return definition.target == EffectTarget::kBase ? "base" : "robot";
  if (!map->Find(key)) {  // diagnosis.json has one key for targets of every kind
    if (const auto target = map->Find("target"))
      target->Fail("this effect states its target as '" + key + "'", key + ": " + target->Text());
  }
  const YamlValue value = map->Get(key);
  if (definition.target == EffectTarget::kJoint) return value.OneOf(JointNames(robot.chain.joints));
  if (definition.target != EffectTarget::kError) return value.Text();
  std::vector<std::string> errors;
  for (const ElementaryTransform& transform : robot.chain.transforms) {
    if (!transform.error.empty()) errors.push_back(transform.error);
  }
  return value.OneOf(errors);
}

// Of an angle (width_deg) in whichever unit it is stated.
struct StatedSetting {
  YamlValue value;
  std::optional<Unit> angle;

  double Number() const { return angle ? ToUnit(value.NumberIn(*angle), UnitNamed("deg")) : value.Number(); }
};

std::optional<StatedSetting> FindSetting(const SettingDefinition& setting, YamlMap* entry) {
  const std::string ending = std::string("_") + UnitNamed("deg").suffix;
  const size_t stem = setting.name.size() - std::min(setting.name.size(), ending.size());
  if (setting.kind == SettingDefinition::Kind::kNumber && setting.name.find(ending, stem) == stem) {
    const auto quantity = entry->FindQuantity(setting.name.substr(0, stem), Dimension::kAngle);
    return quantity ? std::optional(StatedSetting{quantity->value, quantity->unit}) : std::nullopt;
  }
  const std::optional<YamlValue> value = entry->Find(setting.name);
  return value ? std::optional(StatedSetting{*value, std::nullopt}) : std::nullopt;
}

std::string ReadSetting(const SettingDefinition& setting, const Robot& robot, const StatedSetting& stated) {
  const YamlValue& value = stated.value;
  switch (setting.kind) {
    case SettingDefinition::Kind::kInteger: {
      const double number = value.Number();
      if (number != std::round(number) || number < setting.least || number > setting.most) {
        value.Fail("a whole number from " + std::to_string(setting.least) + " to " + std::to_string(setting.most) +
                   " is needed");
      }
      return std::to_string(static_cast<int>(number));
    }
    case SettingDefinition::Kind::kNumber:
    case SettingDefinition::Kind::kMoment: {
      const double number = stated.Number();
      const std::string text = FormatNumber(number);
      if (text != setting.fallback && number <= setting.above) {
        value.Fail("a number above " + FormatNumber(setting.above) + " is needed");
      }
      return text;
    }
    case SettingDefinition::Kind::kJoint:
      return value.OneOf(JointNames(robot.chain.joints));
    case SettingDefinition::Kind::kChoice:
      return value.OneOf(setting.choices);
  }
  return "";
}

// Lengths and angles may be stated in any of their units; nothing for everything else.
std::optional<Dimension> DimensionOf(Quantity quantity) {
  if (quantity == Quantity::kLength) return Dimension::kLength;
  if (quantity == Quantity::kShift) return Dimension::kSmallLength;
  if (quantity == Quantity::kAngle || quantity == Quantity::kSmallAngle) return Dimension::kAngle;
  return std::nullopt;
}

std::optional<double> ReadParameter(const EffectParameter& parameter, YamlMap* map) {
  if (const auto dimension = DimensionOf(parameter.quantity)) return map->Find(parameter.name, *dimension);
  const auto value = map->Find(ParameterKey(parameter.name, parameter.quantity));
  if (!value) return std::nullopt;
  return value->Number() * TraitsOf(parameter.quantity).si_per_unit;
}

EffectSpec ReadEffect(const YamlValue& item, const Robot& robot) {
  YamlMap map(item);
  const std::string name = map.Get("effect").Text();
  const EffectDefinition* definition = FindEffect(robot, name);
  EffectSpec spec;
  spec.effect = name;
  if (IsGravityCompensator(spec)) {
    map.Get("effect").Fail("a gravity compensator has a key of its own in the robot file",
                           "gravity_compensator: {joint: …, type: spring, L_mm: …}, next to effects");
  }
  if (definition == nullptr) {
    map.Get("effect").Fail("there is no effect '" + name + "'", SpellingHint(name, EffectNames(robot)));
  }
  spec.target = ReadEffectTarget(*definition, robot, &map);
  ReadSettings(*definition, robot, &map, &spec);
  const std::string slides = JointThatSlides(robot.chain, *definition, spec);
  if (!slides.empty()) map.Get("effect").Fail(IsForJointsThatTurn(slides));
  const std::vector<EffectParameter> parameters = definition->parameters(robot, spec);
  for (const EffectParameter& parameter : parameters) {
    spec.values.push_back(ReadParameter(parameter, &map).value_or(0.0));
  }
  spec.prior_sigmas = ReadPriors(parameters, &map);
  map.Finish();
  return spec;
}

// What reads back to the last bit, where the unit is one of several.
double InItsUnit(Quantity quantity, double value) {
  const QuantityTraits& traits = TraitsOf(quantity);
  return DimensionOf(quantity) ? ToUnit(value, UnitNamed(traits.unit)) : value / traits.si_per_unit;
}

Json SettingToJson(const EffectDefinition& definition, const std::string& name, const std::string& text) {
  for (const SettingDefinition& setting : definition.settings) {
    if (setting.name != name) continue;
    if (setting.kind == SettingDefinition::Kind::kInteger) return std::stoi(text);
    const bool is_number =
        setting.kind == SettingDefinition::Kind::kNumber || setting.kind == SettingDefinition::Kind::kMoment;
    if (const auto number = ParseNumber(text); is_number && number) return *number;
  }
  return text;
}

}  // namespace

void ReadSettings(const EffectDefinition& definition, const Robot& robot, YamlMap* entry, EffectSpec* use) {
  for (const SettingDefinition& setting : definition.settings) {
    if (const auto stated = FindSetting(setting, entry)) {
      if (!setting.MeansSomethingFor(*use)) stated->value.Fail("this goes with " + setting.only_with + " only");
      const std::string text = ReadSetting(setting, robot, *stated);
      if (!setting.greater_than.empty() && stated->Number() <= use->NumberSetting(setting.greater_than, 0.0)) {
        stated->value.Fail("this must be greater than '" + setting.greater_than + "'");
      }
      if (!setting.silent || text != setting.FallbackFor(robot)) use->settings[setting.name] = text;
    } else if (setting.silent || !setting.MeansSomethingFor(*use)) {
      continue;
    } else if (setting.fallback.empty()) {
      entry->Get(setting.name);  // says what is missing
    } else {
      use->settings[setting.name] = setting.fallback;
    }
  }
}

std::vector<double> ReadPriors(const std::vector<EffectParameter>& parameters, YamlMap* entry) {
  const auto value = entry->Find(kPriorSigma);
  if (!value) return {};
  YamlMap map(*value);
  std::vector<double> sigmas;
  for (const EffectParameter& parameter : parameters) {
    sigmas.push_back(ReadParameter(parameter, &map).value_or(0.0));
    if (sigmas.back() < 0.0) value->Fail("a standard deviation is positive; 0: no prior");
  }
  map.Finish();
  return sigmas;
}

void PutPriors(const std::vector<EffectParameter>& parameters, const std::vector<double>& sigmas, Json* entry) {
  Json priors = Json::object();
  for (size_t p = 0; p < sigmas.size(); ++p) {
    if (!(sigmas[p] > 0.0)) continue;
    priors[ParameterKey(parameters[p].name, parameters[p].quantity)] = InItsUnit(parameters[p].quantity, sigmas[p]);
  }
  if (!priors.empty()) (*entry)[kPriorSigma] = std::move(priors);
}

std::vector<EffectParameter> SpringParameters() {
  std::vector<EffectParameter> parameters;
  for (const CompensatorPart part : kCompensatorParts) {
    parameters.push_back({WordOf(part), part == CompensatorPart::kKc ? Quantity::kSpringRate : Quantity::kLength});
  }
  return parameters;
}

std::string ParameterKey(const std::string& name, Quantity quantity) {
  std::string unit = TraitsOf(quantity).unit;
  const size_t slash = unit.find('/');
  if (slash != std::string::npos) unit.replace(slash, 1, "_per_");
  return name + "_" + unit;
}

std::string TargetKey(EffectTarget target) {
  switch (target) {
    case EffectTarget::kJoint:
      return "joint";
    case EffectTarget::kError:
      return "error";
    case EffectTarget::kStation:
      return "station";
    case EffectTarget::kLoad:
      return "load";
    case EffectTarget::kMarker:
      return "marker";
    case EffectTarget::kBase:
    case EffectTarget::kRobot:
      return "";
  }
  return "";
}

std::vector<EffectSpec> ReadEffects(const YamlValue& value, const Robot& robot) {
  std::vector<EffectSpec> effects;
  if (value.IsNull()) return effects;
  for (const YamlValue& item : value.Items()) {
    EffectSpec spec = ReadEffect(item, robot);
    const auto same = [&](const EffectSpec& other) { return other.Path() == spec.Path(); };
    if (std::any_of(effects.begin(), effects.end(), same)) item.Fail("the effect " + spec.Path() + " stands twice");
    effects.push_back(std::move(spec));
  }
  return effects;
}

Json SettingsToJson(const Robot& robot, const EffectSpec& spec) {
  Json json = Json::object();
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition == nullptr) return json;
  for (const auto& [name, text] : spec.settings) json[name] = SettingToJson(*definition, name, text);
  return json;
}

Json EffectToJson(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition& definition = *FindEffect(robot, spec.effect);
  Json json = {{"effect", spec.effect}};
  const std::string target = TargetKey(definition.target);
  if (!target.empty()) json[target] = spec.target;
  json.update(SettingsToJson(robot, spec));
  const std::vector<EffectParameter> parameters = definition.parameters(robot, spec);
  for (size_t p = 0; p < parameters.size(); ++p) {
    const std::string key = ParameterKey(parameters[p].name, parameters[p].quantity);
    const double value = p < spec.values.size() ? spec.values[p] : 0.0;
    json[key] = InItsUnit(parameters[p].quantity, value);
  }
  PutPriors(parameters, spec.prior_sigmas, &json);
  return json;
}

}  // namespace sagitta
