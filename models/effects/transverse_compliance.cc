// The frame right after the joint tilts about its two other axes, times the
// moment about each.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace transverse_compliance {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {NotNegative({"ku", Quantity::kCompliance, 2e-4, true}),
          NotNegative({"kv", Quantity::kCompliance, 2e-4, true})};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const Axis axis = AxisOf(context.chain(), context.joint());
  for (int which = 0; which < 2; ++which) {
    const int slot = TiltSlot(context.chain(), context.joint(), OtherAxis(axis, which));
    terms->elastic.push_back({slot, context.first_parameter + which, 1.0, ElasticLaw::kLinear});
  }
}

}  // namespace transverse_compliance

const EffectDefinition& TransverseCompliance() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"transverse_compliance",           "tilting of a joint under load",
                            "bearing and housing compliance",  EffectTarget::kJoint,
                            transverse_compliance::Parameters, transverse_compliance::Apply};
    effect.tilts = true;
    effect.needs = EffectNeeds::kLoads;
    effect.on_slide = OnSlide::kStated;
    effect.separate_by = kSeparateByLoads;
    effect.sizes = "a tenth to a third of the compliance about the axis (moment stiffness in gear data sheets)";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
