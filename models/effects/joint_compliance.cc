// Deflection about the axis = k * torque of everything beyond; paper 000 eq. (2).
#include "models/effects/catalogue.h"

namespace sagitta {
namespace joint_compliance {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"k", Quantity::kCompliance, 1e-3, true}};
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
