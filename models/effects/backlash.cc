// Encoder side: -half_gap * approach, or +half_gap * sign(torque): the torque
// presses the output against one side of the gap. Friction holds it somewhere
// between where the torque is small against it: with a width,
// half_gap * tanh(torque / width). Friction wind-up has the same signature.
#include "models/effects/catalogue.h"
#include "models/effects/joint_error.h"

namespace sagitta {
namespace backlash {

std::vector<EffectParameter> Parameters(const Robot& robot, const EffectSpec& spec) {
  return {NotNegative(JointError("half_gap", robot, spec, 50e-6, 20e-6))};
}

bool IsStated(const EffectContext& context) { return context.shot->StatesApproachOf(context.joint()); }

PressedBy By(const EffectSpec& spec) {
  return spec.TextSetting("by", "approach") == "torque" ? PressedBy::kTorque : PressedBy::kApproach;
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const double sign = context.joint_sign();
  if (By(*context.spec) == PressedBy::kTorque) {
    const double width = context.spec->NumberSetting("width_Nm", 0.0);
    terms->elastic.push_back({context.joint_slot(), context.first_parameter, sign * sign, ElasticLaw::kSign, width});
  } else if (IsStated(context)) {
    const double approach = context.shot->approach[context.joint()];
    terms->slots.push_back({context.joint_slot(), context.first_parameter, -sign * approach});
  }
}

std::string Missing(const EffectContext& context) {
  if (By(*context.spec) == PressedBy::kTorque || IsStated(context)) return "";
  return "approach" + std::to_string(context.joint() + 1);
}

}  // namespace backlash

const EffectDefinition& Backlash() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"backlash",           "backlash (or friction wind-up)",
                            "play of a gear",     EffectTarget::kJoint,
                            backlash::Parameters, backlash::Apply};
    effect.settings = {{"by", SettingDefinition::Kind::kChoice, "approach", {"approach", "torque"}},
                       {"width_Nm",
                        SettingDefinition::Kind::kNumber,
                        "0",
                        {"1", "3", "10", "30", "55", "100", "170", "300", "550", "1000"}}};
    effect.settings[1].silent = true;
    effect.settings[1].above = 0.0;
    effect.settings[1].only_with = "by=torque";
    effect.missing = backlash::Missing;
    effect.pressed_by = backlash::By;
    effect.separate_by = "the same poses approached from both sides";
    effect.note = "Friction wind-up has the same signature.";
    effect.largest = 1.0;
    effect.sizes =
        "lost motion below 1 arcmin (291 urad) in data sheets of precision gears; a third of its half without load. Of "
        "rack and pinion 3 arcmin on a pinion of 50 mm radius, 44 um, of which half";
    effect.on_slide = OnSlide::kDiagnosed;
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
