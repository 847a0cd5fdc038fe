// A geometric error held at nominal is not nominal.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace frozen_geometry {

std::vector<EffectParameter> Parameters(const Robot& robot, const EffectSpec& spec) {
  const int slot = robot.chain.FindError(spec.target);
  const bool turns = slot >= 0 && robot.chain.transforms[slot].is_rotation();
  return {{"value", turns ? Quantity::kAngle : Quantity::kLength, 3e-4}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  terms->slots.push_back({context.chain().FindError(context.spec->target), context.first_parameter, 1.0});
}

}  // namespace frozen_geometry

const EffectDefinition& FrozenGeometry() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"frozen_geometry",    "frozen geometric error",    "identification Jacobian, paper 002",
                            EffectTarget::kError, frozen_geometry::Parameters, frozen_geometry::Apply};
    effect.separate_by = "unloaded poses that turn every joint over its whole range, markers apart from each other";
    effect.sizes =
        "identified errors of industrial arms: 0.1 to 0.5 mm and 0.005 to 0.03 deg (papers 000 and 002, KUKA KR 270)";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
