// The link's mass at the joint's origin and its first moment in the frame right
// after the joint load all joints up to it: (R m c) x g is the moment of +g at c
// and -g at the origin.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace link_gravity {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {NotNegative({"mass", Quantity::kMass, 3e-4, true}),
          {"mx", Quantity::kFirstMoment, 3e-4, true},
          {"my", Quantity::kFirstMoment, 3e-4, true},
          {"mz", Quantity::kFirstMoment, 3e-4, true}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const int frame = context.chain().FrameAfterJoint(context.joint());
  const ShotConditions& shot = *context.shot;
  const auto weight_at = [&](const Vector3<double>& point, double times) {
    return AppliedWrench{frame, point, times * shot.gravity, Vector3<double>::Zero(), shot.gravity_frame};
  };
  const Vector3<double> origin = Vector3<double>::Zero();
  terms->wrenches.push_back({context.first_parameter, {weight_at(origin, 1.0)}});
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<AppliedWrench> couple = {weight_at(Vector3<double>::Unit(axis), 1.0), weight_at(origin, -1.0)};
    terms->wrenches.push_back({context.first_parameter + 1 + axis, couple});
  }
}

}  // namespace link_gravity

const EffectDefinition& LinkGravity() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"link_gravity",       "weight of a link",       "statics of the links",
                            EffectTarget::kJoint, link_gravity::Parameters, link_gravity::Apply};
    effect.needs = EffectNeeds::kCompliances;
    effect.one_size = true;
    effect.is_weight = true;
    effect.on_slide = OnSlide::kStated;
    effect.separate_by = kSeparateByWeight;
    effect.note = "All that is fixed to the link counts: a drive, cables, on the last link flange and tool.";
    effect.sizes =
        "links weigh as much as the load, at a third of its lever: a third of the deflection under rated load";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
