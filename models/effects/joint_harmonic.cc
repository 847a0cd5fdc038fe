// Encoder side: cos * cos(n q) + sin * sin(n q); 1 = eccentricity of the encoder
// disc, the gear ratio = transmission error of the input stage.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace joint_harmonic {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"cos", Quantity::kSmallAngle, 75e-6}, {"sin", Quantity::kSmallAngle, 75e-6}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const double phase = context.spec->IntegerSetting("order", 1) * context.shot->q[context.joint()];
  const int slot = context.joint_slot();
  const double sign = context.chain().transforms[slot].sign;
  terms->slots.push_back({slot, context.first_parameter, sign * std::cos(phase)});
  terms->slots.push_back({slot, context.first_parameter + 1, sign * std::sin(phase)});
}

}  // namespace joint_harmonic

const EffectDefinition& JointHarmonic() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "joint_harmonic",     "periodic joint error",     "encoder eccentricity, gear transmission error",
        EffectTarget::kJoint, joint_harmonic::Parameters, joint_harmonic::Apply};
    effect.settings = {{"order", SettingDefinition::Kind::kInteger, "1", {}}};
    effect.separate_by = kSeparateByRange;
    effect.largest = 1.0;
    effect.sizes =
        "transmission error of strain wave and cycloidal gears: 0.5 to 1.5 arcmin (145 to 436 urad) from peak to peak "
        "in data sheets";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
