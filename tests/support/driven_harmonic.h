// The example of docs/ADDING_AN_EFFECT.md: its code stands here word for word (tests/repository_test.py compares them).
#pragma once

#include <cmath>

#include "estimator/diagnosis/diagnose.h"
#include "models/effects/effect.h"
#include "problems/io/robot_file.h"

namespace sagitta::test {

inline std::vector<EffectParameter> DrivenParameters(const Robot&, const EffectSpec&) {
  constexpr double kTypical = 50e-6;  // rad
  return {{"cos", Quantity::kSmallAngle, kTypical}, {"sin", Quantity::kSmallAngle, kTypical}};
}

inline void ApplyDriven(const EffectContext& context, ShotTerms* terms) {
  const int driver = context.chain().FindJoint(context.spec->TextSetting("driver", ""));
  const double phase = context.spec->IntegerSetting("order", 1) * context.shot->q[driver];
  const double sign = context.joint_sign();
  terms->slots.push_back({context.joint_slot(), context.first_parameter, sign * std::cos(phase)});
  terms->slots.push_back({context.joint_slot(), context.first_parameter + 1, sign * std::sin(phase)});
}

inline const EffectDefinition& DrivenHarmonic() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect;
    effect.name = "driven_harmonic";
    effect.title = "periodic error driven by another joint";
    effect.reference = "where it is described";
    effect.target = EffectTarget::kJoint;
    effect.parameters = DrivenParameters;
    effect.apply = ApplyDriven;
    effect.settings = {{"driver", SettingDefinition::Kind::kJoint, "", {}},
                       {"order", SettingDefinition::Kind::kInteger, "1", {}}};
    effect.separate_by = "poses with {target} and its driver over their whole ranges";
    effect.sizes = "transmission error in the gear's data sheet";
    return effect;
  }();
  return definition;
}

inline Diagnosis DiagnoseMine(const std::string& robot_file, const Measurements& data, const Experiment& experiment) {
  const Robot robot = ReadRobotFile(robot_file, {&DrivenHarmonic()});  // or robot.own_effects = {&DrivenHarmonic()}
  return Diagnose(MakeCalibrationProblem(robot, data, experiment), DiagnosisOptions());
}

// What is left of an arrival: 1 at a new pose, then half as much with every further shot at it.
inline std::vector<double> RememberArrivals(const Robot&, const EffectSpec&,
                                            const std::vector<const ShotConditions*>& campaign) {
  std::vector<double> left;
  for (size_t i = 0; i < campaign.size(); ++i) {
    left.push_back(i > 0 && campaign[i]->q == campaign[i - 1]->q ? 0.5 * left.back() : 1.0);
  }
  return left;
}

inline void ApplySettling(const EffectContext& context, ShotTerms* terms) {
  terms->slots.push_back({context.joint_slot(), context.first_parameter, context.joint_sign() * context.memory});
}

}  // namespace sagitta::test
