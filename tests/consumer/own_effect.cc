// An effect of one's own: joint 3's gear is turned by joint 2, so that joint 3 is off by cos . cos(n q2) + sin . sin(n
// q2). The robot carries the definition; calibration estimates it like any other.
//
// usage: own_effect EXPERIMENT.yaml OUT_FOLDER
#include <sagitta/sagitta.h>

#include <cmath>
#include <iostream>

namespace {

using sagitta::EffectContext;
using sagitta::EffectDefinition;
using sagitta::EffectParameter;
using sagitta::EffectSpec;
using sagitta::EffectTarget;
using sagitta::Quantity;
using sagitta::Robot;
using sagitta::SettingDefinition;
using sagitta::ShotTerms;

std::vector<EffectParameter> DrivenParameters(const Robot&, const EffectSpec&) {
  return {{"cos", Quantity::kSmallAngle}, {"sin", Quantity::kSmallAngle}};  // cos_urad, sin_urad in files
}

void ApplyDriven(const EffectContext& context, ShotTerms* terms) {
  const int driver = context.chain().FindJoint(context.spec->TextSetting("driver", ""));
  const double phase = context.spec->IntegerSetting("order", 1) * context.shot->q[driver];
  const double sign = context.joint_sign();
  terms->slots.push_back({context.joint_slot(), context.first_parameter, sign * std::cos(phase)});
  terms->slots.push_back({context.joint_slot(), context.first_parameter + 1, sign * std::sin(phase)});
}

const EffectDefinition& DrivenHarmonic() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"driven_harmonic",       "periodic error driven by another joint",
                            "where it is described", EffectTarget::kJoint,
                            DrivenParameters,        ApplyDriven};
    effect.settings = {{"driver", SettingDefinition::Kind::kJoint, "", {}},
                       {"order", SettingDefinition::Kind::kInteger, "1", {}}};
    effect.separate_by = "poses with {target} and its driver over their whole ranges";
    return effect;
  }();
  return definition;
}

}  // namespace

int main(int, char** argv) {
  sagitta::ExperimentInputs inputs = sagitta::ReadExperimentInputs({argv[1]});
  inputs.robot.own_effects = {&DrivenHarmonic()};
  inputs.robot.effects.push_back({"driven_harmonic",
                                  inputs.robot.chain.joints[2].name,
                                  {{"driver", inputs.robot.chain.joints[1].name}, {"order", "2"}},
                                  {}});
  const sagitta::Calibration result =
      sagitta::Calibrate(sagitta::MakeCalibrationProblem(inputs.robot, inputs.data, inputs.experiment));
  int found = 0;
  for (const sagitta::ParameterEstimate& row : result.estimate.table) {
    if (row.name.rfind("effect/driven_harmonic", 0) != 0) continue;
    std::cout << row.name << " = " << 1e6 * row.value << " urad, 95 % from " << 1e6 * row.ci95.low << " to "
              << 1e6 * row.ci95.high << "\n";
    found += std::abs(row.value) < 4.0 * row.sigma;  // nothing of the kind is in the data
  }
  if (!sagitta::IsUsable(result.estimate.status) || found != 2) return 1;
  // What reads the file later, in another program, needs the definition as well.
  sagitta::WriteCalibration(result, argv[2]);
  const sagitta::KnownRobot known =
      sagitta::ReadEstimateFile(std::string(argv[2]) + "/estimate.json", {&DrivenHarmonic()});
  const sagitta::Prediction prediction = sagitta::Predict(known, inputs.data);
  return (prediction.points - result.estimate.predicted).cwiseAbs().maxCoeff() < 1e-9 ? 0 : 1;
}
