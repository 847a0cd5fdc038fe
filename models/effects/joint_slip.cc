// Encoder side: the zero of a joint jumps once.
#include "models/effects/catalogue.h"
#include "models/effects/joint_error.h"

namespace sagitta {
namespace joint_slip {

std::vector<EffectParameter> Parameters(const Robot& robot, const EffectSpec& spec) {
  return {JointError("jump", robot, spec, 100e-6, 100e-6)};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->time <= context.spec->NumberSetting("after_s", 0.0)) return;
  terms->slots.push_back({context.joint_slot(), context.first_parameter, context.joint_sign()});
}

}  // namespace joint_slip

const EffectDefinition& JointSlip() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"joint_slip",         "zero shift of a joint", "slipped coupling, lost mastering",
                            EffectTarget::kJoint, joint_slip::Parameters,  joint_slip::Apply};
    effect.settings = {{"after_s", SettingDefinition::Kind::kMoment, "", {}}};
    effect.driven_by = EffectDriver::kTime;
    effect.separate_by = kSeparateByReturn;
    effect.largest = 100.0;  // 0.1 rad: a tooth of a belt pulley with sixty
    effect.on_slide = OnSlide::kDiagnosed;
    effect.sizes =
        "mastering repeats to some 0.005 deg (87 urad), makers' instructions; a linear axis is referenced to some "
        "0.1 mm (switch and index pulse)";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
