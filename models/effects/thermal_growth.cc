// Arm and tool grow about the base origin with temperature - its mean; what stands on the floor or the foot does not.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) { return {{"growth", Quantity::kGrowth}}; }

void Apply(const EffectContext& context, ShotTerms* terms) {
  terms->base.push_back({context.first_parameter, context.shot->temperature});
}

}  // namespace

const EffectDefinition& ThermalGrowth() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "thermal_growth", "thermal growth of the arm", "linear expansion", EffectTarget::kRobot, Parameters, Apply};
    effect.driven_by = EffectDriver::kTemperature;
    effect.separate_by = "the same poses at other temperatures, in an order that is not that of time";
    effect.note = "Links that lag behind the thermometer bias the value.";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
