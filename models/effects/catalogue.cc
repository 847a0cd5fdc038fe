#include "models/effects/catalogue.h"

namespace sagitta {

std::string MissingColumn(const EffectDefinition& definition, const EffectContext& context) {
  const EffectDriver by = definition.DrivenBy(*context.spec);
  if (by == EffectDriver::kTime && !context.shot->has_time) return "time_s";
  if (by == EffectDriver::kTemperature && !context.shot->has_temperature) return "temperature_degC";
  return definition.missing == nullptr ? "" : definition.missing(context);
}

const std::vector<const EffectDefinition*>& EffectCatalogue() {
  static const std::vector<const EffectDefinition*> catalogue = {
      &FrozenGeometry(),
      &JointComplianceEffect(),
      &ComplianceHardening(),
      &TransverseCompliance(),
      &LinkGravity(),
      &SelfWeightSag(),
      &BaseCompliance(),
      &Payload(),
      &JointHarmonic(),
      &AxisWobble(),
      &EncoderGain(),
      &JointCoupling(),
      &Backlash(),
      &JointSlip(),
      &ThermalGrowth(),
      &StationDrift(),
      &StationScale(),
      &MarkerShift(),
      &WarmUp(),
      &StationEccentricity(),
      &StationRangeOffset(),
      &LoadCom(),
      &Hysteresis(),
      &MarkerAcceptance(),
      &StationRefraction(),
      &LearntDeviation(),
      &LearntWaveDeviation(),
      &LearntJumpDeviation(),
      &LearntPairDeviation(),
      &LearntProductDeviation(),
      &LearntSurfaceDeviation(),
      &LearntGrowth(),
      &LearntStationMotion(),
      &LearntStationWave(),
      &LearntMarkerMotion(),
      &LearntMarkerSeat(),
      &LearntToolMotion(),
      &LearntStationField(),
      &LearntLoadShift(),
      &LearntLoadSlide(),
      &LearntPull(),
      &LearntLag(),
      &LearntReading(),
      &LearntRangeWave(),
  };
  return catalogue;
}

namespace {

using Definitions = std::vector<const EffectDefinition*>;

const EffectDefinition* FindIn(const Definitions& definitions, const std::string& name) {
  for (const EffectDefinition* definition : definitions) {
    if (definition->name == name) return definition;
  }
  return nullptr;
}

std::vector<std::string> NamesOf(const Definitions& definitions) {
  std::vector<std::string> names;
  for (const EffectDefinition* definition : definitions) names.push_back(definition->name);
  return names;
}

}  // namespace

const EffectDefinition* FindEffect(const std::string& name) { return FindIn(EffectCatalogue(), name); }

std::vector<std::string> EffectNames() { return NamesOf(EffectCatalogue()); }

Definitions EffectsOf(const Robot& robot) {
  Definitions definitions = EffectCatalogue();
  definitions.insert(definitions.end(), robot.own_effects.begin(), robot.own_effects.end());
  return definitions;
}

const EffectDefinition* FindEffect(const Robot& robot, const std::string& name) {
  const EffectDefinition* shipped = FindEffect(name);
  return shipped != nullptr ? shipped : FindIn(robot.own_effects, name);
}

std::vector<std::string> EffectNames(const Robot& robot) { return NamesOf(EffectsOf(robot)); }

const EffectDefinition* EffectOfName(const std::string& name) {
  const std::string family = "effect/";
  if (name.compare(0, family.size(), family) != 0) return nullptr;
  return FindEffect(name.substr(family.size(), name.find_first_of("[/", family.size()) - family.size()));
}

bool GoesWithTime(const Robot& robot, const EffectSpec& spec) {
  return FindEffect(robot, spec.effect)->DrivenBy(spec) == EffectDriver::kTime;
}

bool CarriesOn(const EffectDefinition& definition, const EffectSpec& spec) {
  if (definition.remember == nullptr) return false;
  return definition.DrivenBy(spec) != EffectDriver::kTemperature || spec.NumberSetting("lag_s", 0.0) > 0.0;
}

std::string MomentOf(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition == nullptr) return "";
  for (const SettingDefinition& setting : definition->settings) {
    if (setting.kind == SettingDefinition::Kind::kMoment && spec.settings.count(setting.name) > 0) return setting.name;
  }
  return "";
}

}  // namespace sagitta
