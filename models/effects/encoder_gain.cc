// Encoder side: gain * (q - middle of the limits), 0 without limits.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace encoder_gain {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"gain", Quantity::kRatio, 100e-6}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const Joint& joint = context.chain().joints[context.joint()];
  const double middle = joint.min && joint.max ? 0.5 * (*joint.min + *joint.max) : 0.0;
  const double q = context.shot->q[context.joint()];
  terms->slots.push_back({context.joint_slot(), context.first_parameter, context.joint_sign() * (q - middle)});
}

}  // namespace encoder_gain

const EffectDefinition& EncoderGain() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "encoder_gain",       "encoder gain",           "scale error of the joint sensor or gear ratio",
        EffectTarget::kJoint, encoder_gain::Parameters, encoder_gain::Apply};
    effect.on_slide = OnSlide::kDiagnosed;
    effect.separate_by = kSeparateByRange;
    effect.sizes = "100 ppm: some 300 urad at the ends of a range of 360 deg, the accuracy of a gear";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
