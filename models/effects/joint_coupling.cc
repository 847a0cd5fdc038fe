// Encoder side: ratio * q of another joint (wrist gears).
#include "models/effects/catalogue.h"

namespace sagitta {
namespace joint_coupling {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"ratio", Quantity::kRatio, 100e-6}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const int driver = context.chain().FindJoint(context.spec->TextSetting("driver", ""));
  terms->slots.push_back(
      {context.joint_slot(), context.first_parameter, context.joint_sign() * context.shot->q[driver]});
}

}  // namespace joint_coupling

const EffectDefinition& JointCoupling() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"joint_coupling",     "coupling between joints",  "wrist gear coupling",
                            EffectTarget::kJoint, joint_coupling::Parameters, joint_coupling::Apply};
    effect.settings = {{"driver", SettingDefinition::Kind::kJoint, "", {}}};
    effect.settings.back().turns = true;
    effect.separate_by = "poses with {target} and its driver over their whole ranges, each independent of the other";
    effect.sizes = "as a wrong gear ratio: 100 ppm, some 300 urad over a range of 360 deg";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
