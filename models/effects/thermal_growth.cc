// Arm and tool grow about the base origin with temperature - its mean.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) { return {{"growth", Quantity::kGrowth}}; }

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->has_temperature) terms->base.push_back({context.first_parameter, context.shot->temperature});
}

std::string Missing(const EffectContext& context) { return context.shot->has_temperature ? "" : "temperature_degC"; }

}  // namespace

const EffectDefinition& ThermalGrowth() {
  static const EffectDefinition definition = {"thermal_growth",
                                              "thermal growth of the arm",
                                              "linear expansion",
                                              EffectTarget::kRobot,
                                              {},
                                              Parameters,
                                              Apply,
                                              Missing,
                                              false};
  return definition;
}

}  // namespace sagitta
