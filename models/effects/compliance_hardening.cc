// + k3 * torque^3 (torque in kN m).
#include "models/effects/catalogue.h"

namespace sagitta {
namespace compliance_hardening {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"k3", Quantity::kHardening, 1e-4, true}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  terms->elastic.push_back({context.joint_slot(), context.first_parameter, 1.0, ElasticLaw::kCubic});
}

}  // namespace compliance_hardening

const EffectDefinition& ComplianceHardening() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "compliance_hardening", "compliance that depends on the load", "progressive stiffness of gears and bearings",
        EffectTarget::kJoint,   compliance_hardening::Parameters,      compliance_hardening::Apply};
    effect.needs = EffectNeeds::kLoads;
    effect.separate_by = "the same poses under several loads, from light to heavy";
    effect.sizes = "a tenth of the linear deflection: the stiffness ranges of gear data sheets differ by 20 to 50 %";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
