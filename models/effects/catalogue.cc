#include "models/effects/catalogue.h"

namespace sagitta {

std::string NothingMissing(const EffectContext&) { return ""; }

std::string TimeMissing(const EffectContext& context) { return context.shot->has_time ? "" : "time_s"; }

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
  };
  return catalogue;
}

const EffectDefinition* FindEffect(const std::string& name) {
  for (const EffectDefinition* definition : EffectCatalogue()) {
    if (definition->name == name) return definition;
  }
  return nullptr;
}

std::vector<std::string> EffectNames() {
  std::vector<std::string> names;
  for (const EffectDefinition* definition : EffectCatalogue()) names.push_back(definition->name);
  return names;
}

}  // namespace sagitta
