// Deflection = sum over links i beyond the joint of axis . ((R_i s_i) x down):
// compliance x weight x arm where no load separates them. The torque of a couple
// (+down at s_i, -down at the origin of frame i) about the slot.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace self_weight_sag {

int LastLink(const Robot& robot) { return robot.num_joints(); }

std::vector<EffectParameter> Parameters(const Robot& robot, const EffectSpec& spec) {
  std::vector<EffectParameter> parameters;
  for (int link = robot.chain.FindJoint(spec.target) + 1; link <= LastLink(robot); ++link) {
    for (const char* axis : {"x", "y", "z"}) {
      parameters.push_back({"s" + std::to_string(link) + axis, Quantity::kSmallAngle, 3e-4});
    }
  }
  return parameters;
}

int Slot(const EffectContext& context) {
  const std::string about = context.spec->TextSetting("about", "axis");
  if (about == "axis") return context.joint_slot();
  const Axis axis = AxisOf(context.chain(), context.joint());
  return TiltSlot(context.chain(), context.joint(), OtherAxis(axis, about == "u" ? 0 : 1));
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  const ShotConditions& shot = *context.shot;
  const Vector3<double> down = shot.gravity.normalized();
  const int slot = Slot(context);
  int parameter = context.first_parameter;
  terms->sags.reserve(terms->sags.size() + static_cast<size_t>(3 * context.chain().num_joints()));
  for (int link = context.joint(); link < context.chain().num_joints(); ++link) {
    const int frame = context.chain().FrameAfterJoint(link);
    for (int axis = 0; axis < 3; ++axis) {
      const AppliedWrench pull{frame, Vector3<double>::Unit(axis), down, Vector3<double>::Zero(), shot.gravity_frame};
      const AppliedWrench back{frame, Vector3<double>::Zero(), -down, Vector3<double>::Zero(), shot.gravity_frame};
      terms->sags.push_back({slot, parameter++, {pull, back}});
    }
  }
}

}  // namespace self_weight_sag

const EffectDefinition& SelfWeightSag() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "self_weight_sag",    "sag under the own weight",  "statics of the links, compliance unknown",
        EffectTarget::kJoint, self_weight_sag::Parameters, self_weight_sag::Apply};
    effect.settings = {{"about", SettingDefinition::Kind::kChoice, "axis", {"axis", "u", "v"}}};
    effect.tilts = true;
    effect.needs = EffectNeeds::kNoCompliances;
    effect.separate_by = kSeparateByWeight;
    effect.sizes =
        "links weigh as much as the load, at a third of its lever: a third of the deflection under rated load";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
