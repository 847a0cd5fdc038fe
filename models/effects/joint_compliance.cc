// Deflection about the axis = k * torque of everything beyond; paper 000 eq. (2).
#include <algorithm>

#include "models/effects/catalogue.h"

namespace sagitta {
namespace joint_compliance {

// It adds to what the robot file states, which may be too much.
bool IsStated(const Robot& robot, const std::string& joint) {
  return std::any_of(robot.compliances.begin(), robot.compliances.end(), [&](const JointCompliance& own) {
    return robot.chain.joints[own.joint].name == joint &&
           std::any_of(own.nodes.begin(), own.nodes.end(), [](const auto& node) { return node.k > 0.0; });
  });
}

std::vector<EffectParameter> Parameters(const Robot& robot, const EffectSpec& spec) {
  const EffectParameter k{"k", Quantity::kCompliance, 1e-3, true};
  return {IsStated(robot, spec.target) ? k : NotNegative(k)};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  terms->elastic.push_back({context.joint_slot(), context.first_parameter, 1.0, ElasticLaw::kLinear});
}

}  // namespace joint_compliance

const EffectDefinition& JointComplianceEffect() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"joint_compliance",   "joint compliance",           "paper 000, eq. (2)",
                            EffectTarget::kJoint, joint_compliance::Parameters, joint_compliance::Apply};
    effect.needs = EffectNeeds::kLoads;
    effect.separate_by = kSeparateByLoads;
    effect.sizes = "0.5 to 2 mrad at rated load: KUKA KR 270 0.3 to 3.5 urad/Nm at some 3000 to 300 Nm (paper 000)";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
