// Effects as results name them: joint_harmonic[order=2]/A3.
#pragma once

#include <string>
#include <vector>

#include "models/effects/effect_spec.h"
#include "models/robot.h"

namespace sagitta {

// The parts between commas outside of brackets, empty ones included; one at least: names of effects and of parameters,
// which may hold several settings.
std::vector<std::string> SplitOutsideBrackets(const std::string& text);

// Two or more, between commas; none of an empty text. `key`: what the user gave them as, for messages. Throws
// InputError: an effect, setting or target that the robot does not have, a setting's value that a robot
// file could not state, a setting or an effect twice, only one effect.
std::vector<EffectSpec> RivalEffects(const Robot& robot, const std::string& names, const std::string& key);

}  // namespace sagitta
