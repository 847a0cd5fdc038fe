// Encoder side: ratio * q of another joint (wrist gears).
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) { return {{"ratio", Quantity::kRatio}}; }

void Apply(const EffectContext& context, ShotTerms* terms) {
  const int driver = context.chain().FindJoint(context.spec->TextSetting("driver", ""));
  terms->slots.push_back(
      {context.joint_slot(), context.first_parameter, context.joint_sign() * context.shot->q[driver]});
}

}  // namespace

const EffectDefinition& JointCoupling() {
  static const EffectDefinition definition = {"joint_coupling",
                                              "coupling between joints",
                                              "wrist gear coupling",
                                              EffectTarget::kJoint,
                                              {{"driver", SettingDefinition::Kind::kJoint, "", {}}},
                                              Parameters,
                                              Apply,
                                              NothingMissing,
                                              false};
  return definition;
}

}  // namespace sagitta
