// Effects as results name them: joint_harmonic[order=2]/A3.
#pragma once

#include <string>
#include <vector>

#include "models/effects/effect_spec.h"
#include "models/robot.h"

namespace sagitta {

// Two or more, between commas; none of an empty text. `key`: what the user gave them as, for messages. Throws
// InputError: an effect, setting or target that the robot does not have, the same effect twice, only one.
std::vector<EffectSpec> RivalEffects(const Robot& robot, const std::string& names, const std::string& key);

}  // namespace sagitta
