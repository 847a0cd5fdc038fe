// Values of an effect's scanned setting (SettingDefinition::choices of a number) between and beyond those that are
// listed.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/diagnose.h"
#include "models/effects/effect.h"

namespace sagitta {

// The scanned setting that the effect states; null: none.
const SettingDefinition* ScannedDefinition(const Robot& robot, const EffectSpec& spec);

// What is listed, one more on either side, values between, and the effect's own: ascending.
std::vector<double> ScanOf(const SettingDefinition& setting, double own);

// The effect with this value of the setting. 0: without it.
EffectSpec At(EffectSpec spec, const std::string& setting, double value);

// Parameters are called by the effect with its settings.
void ChangeTo(const EffectSpec& changed, Candidate* candidate);

// An effect that goes by the sign of a torque, rounded: chi-square jumps where a parameter turns the sign in a shot,
// and a refit finds no optimum there. A third of the least width that is listed, a third of that, and so on: what is
// less than the weights leave open of the torque does not jump less than the sign. Empty: it goes by no sign.
std::vector<EffectSpec> Rounded(const Robot& robot, const EffectSpec& spec);

}  // namespace sagitta
