// Encoder side: -half_gap * approach, or +half_gap * sign(torque). Friction
// wind-up has the same signature.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"half_gap", Quantity::kSmallAngle}};
}

bool IsStated(const EffectContext& context) { return context.shot->StatesApproachOf(context.joint()); }

void Apply(const EffectContext& context, ShotTerms* terms) {
  const double sign = context.joint_sign();
  if (context.spec->TextSetting("by", "approach") == "torque") {
    terms->elastic.push_back({context.joint_slot(), context.first_parameter, sign * sign, ElasticLaw::kSign});
  } else if (IsStated(context)) {
    const double approach = context.shot->approach[context.joint()];
    terms->slots.push_back({context.joint_slot(), context.first_parameter, -sign * approach});
  }
}

std::string Missing(const EffectContext& context) {
  if (context.spec->TextSetting("by", "approach") == "torque" || IsStated(context)) return "";
  return "approach" + std::to_string(context.joint() + 1);
}

}  // namespace

const EffectDefinition& Backlash() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "backlash", "backlash (or friction wind-up)", "play of a gear", EffectTarget::kJoint, Parameters, Apply};
    effect.settings = {{"by", SettingDefinition::Kind::kChoice, "approach", {"approach", "torque"}}};
    effect.missing = Missing;
    effect.separate_by = "the same poses approached from both sides";
    effect.note = "Friction wind-up has the same signature.";
    effect.largest = 1.0;
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
