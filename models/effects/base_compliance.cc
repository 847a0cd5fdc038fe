// The foot tilts about the base's x and y at its origin, times the moments.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace base_compliance {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {NotNegative({"kx", Quantity::kCompliance, 1e-4, true}),
          NotNegative({"ky", Quantity::kCompliance, 1e-4, true})};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  for (int axis = 0; axis < 2; ++axis) {
    const int slot = TiltSlot(context.chain(), -1, static_cast<Axis>(axis));
    terms->elastic.push_back({slot, context.first_parameter + axis, 1.0, ElasticLaw::kLinear});
  }
}

}  // namespace base_compliance

const EffectDefinition& BaseCompliance() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "base_compliance",   "tilting of the foot under load", "compliance of foundation or pedestal",
        EffectTarget::kBase, base_compliance::Parameters,      base_compliance::Apply};
    effect.tilts = true;
    effect.needs = EffectNeeds::kLoads;
    effect.separate_by = kSeparateByLoads;
    effect.sizes = "0.1 mm per metre at rated load: pedestals and anchor bolts";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
