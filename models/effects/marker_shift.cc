// A reflector was reseated: its point jumps once, in the frame it is on.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace marker_shift {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"x", Quantity::kLength, 50e-6}, {"y", Quantity::kLength, 50e-6}, {"z", Quantity::kLength, 50e-6}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->time <= context.spec->NumberSetting("after_s", 0.0)) return;
  for (size_t m = 0; m < context.markers->size(); ++m) {
    if ((*context.markers)[m] != context.spec->target) continue;
    for (int axis = 0; axis < 3; ++axis) {
      terms->markers.push_back({static_cast<int>(m), context.first_parameter + axis, Vector3<double>::Unit(axis)});
    }
  }
}

}  // namespace marker_shift

const EffectDefinition& MarkerShift() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"marker_shift",        "reseated marker",        "reflector moved in its nest",
                            EffectTarget::kMarker, marker_shift::Parameters, marker_shift::Apply};
    effect.settings = {{"after_s", SettingDefinition::Kind::kMoment, "", {}}};
    effect.driven_by = EffectDriver::kTime;
    effect.separate_by = kSeparateByReturn;
    effect.sizes = "a nest holds a reflector to some 10 um, glue and magnets to some 0.1 mm";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
