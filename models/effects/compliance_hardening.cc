// + k3 * torque^3 (torque in kN m).
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) { return {{"k3", Quantity::kHardening}}; }

void Apply(const EffectContext& context, ShotTerms* terms) {
  terms->elastic.push_back({context.joint_slot(), context.first_parameter, 1.0, ElasticLaw::kCubic});
}

}  // namespace

const EffectDefinition& ComplianceHardening() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"compliance_hardening",
                            "compliance that depends on the load",
                            "progressive stiffness of gears and bearings",
                            EffectTarget::kJoint,
                            Parameters,
                            Apply};
    effect.needs = EffectNeeds::kLoads;
    effect.separate_by = "the same poses under several loads, from light to heavy";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
