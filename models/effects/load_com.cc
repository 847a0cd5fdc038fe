// The load's centre of gravity is off the stated point by d (flange frame): its
// force F acts at point + d, which is the moment d x F more. The moment of +F at
// point + d and -F at the point.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace load_com {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"dx", Quantity::kLength, 20e-3}, {"dy", Quantity::kLength, 20e-3}, {"dz", Quantity::kLength, 20e-3}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const ShotConditions& shot = *context.shot;
  if (shot.load != context.spec->target) return;
  for (const AppliedWrench& wrench : shot.load_wrenches) {
    for (int axis = 0; axis < 3; ++axis) {
      AppliedWrench there = wrench, back = wrench;
      there.moment.setZero();
      back.moment.setZero();
      there.point += Vector3<double>::Unit(axis);
      back.force = -wrench.force;
      terms->wrenches.push_back({context.first_parameter + axis, {there, back}});
    }
  }
}

}  // namespace load_com

const EffectDefinition& LoadCom() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"load_com",           "load point off the stated one",
                            "statics: M = d x F", EffectTarget::kLoad,
                            load_com::Parameters, load_com::Apply};
    effect.needs = EffectNeeds::kLoads;
    effect.is_weight = true;
    effect.separate_by = "the load hung on another point, or poses that turn the flange about all its axes";
    effect.sizes = "centres of gravity read from a drawing or estimated by eye: 10 to 30 mm";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
