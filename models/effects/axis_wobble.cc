// The axis of a joint tilts about its two other directions as harmonics of q.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace axis_wobble {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"u_cos", Quantity::kSmallAngle, 50e-6},
          {"u_sin", Quantity::kSmallAngle, 50e-6},
          {"v_cos", Quantity::kSmallAngle, 50e-6},
          {"v_sin", Quantity::kSmallAngle, 50e-6}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const double phase = context.spec->IntegerSetting("order", 1) * context.shot->q[context.joint()];
  const Axis axis = AxisOf(context.chain(), context.joint());
  for (int which = 0; which < 2; ++which) {
    const int slot = TiltSlot(context.chain(), context.joint(), OtherAxis(axis, which));
    terms->slots.push_back({slot, context.first_parameter + 2 * which, std::cos(phase)});
    terms->slots.push_back({slot, context.first_parameter + 2 * which + 1, std::sin(phase)});
  }
}

}  // namespace axis_wobble

const EffectDefinition& AxisWobble() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"axis_wobble",        "axis wobble",           "bearing run-out",
                            EffectTarget::kJoint, axis_wobble::Parameters, axis_wobble::Apply};
    effect.settings = {{"order", SettingDefinition::Kind::kInteger, "1", {}, 2}};
    effect.tilts = true;
    effect.separate_by = kSeparateByRange;
    effect.largest = 1.0;
    effect.sizes = "run-out of 10 um over a bearing of 200 mm (ISO 492, normal class)";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
