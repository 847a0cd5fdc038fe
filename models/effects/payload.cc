// The load has another mass than stated: a force along gravity at the load point.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace payload {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"dmass", Quantity::kMass, 5e-5, true}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const ShotConditions& shot = *context.shot;
  if (shot.load != context.spec->target || shot.load_wrenches.empty()) return;
  AppliedWrench extra = shot.load_wrenches.front();
  extra.force = shot.gravity;
  extra.moment.setZero();
  extra.expressed_in = shot.gravity_frame;
  terms->wrenches.push_back({context.first_parameter, {extra}});
}

}  // namespace payload

const EffectDefinition& Payload() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"payload",           "mass of the load not as stated",
                            "weighing error",    EffectTarget::kLoad,
                            payload::Parameters, payload::Apply};
    effect.needs = EffectNeeds::kLoads;
    effect.is_weight = true;
    effect.separate_by = "the load weighed, or the same poses under another load";
    effect.sizes = "5 % of the load: what weighing and forgotten adapters leave, times a deflection of 1 mrad";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
