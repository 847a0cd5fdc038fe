// Effects of a known robot that go with what was done before: play that a way leaves, heat, a body that follows its
// thermometer late.
#pragma once

#include <string>
#include <vector>

namespace sagitta {

struct EffectDefinition;
struct KnownRobot;

// Whether the flange is elsewhere by it: what an instrument reads and where markers sit moves no arm.
bool MovesTheArm(const EffectDefinition& effect);

// Paths (EffectSpec::Path) of those that act, in the robot's order.
std::vector<std::string> RememberingEffects(const KnownRobot& known);

// Of them those that move the arm.
std::vector<std::string> RememberingEffectsOfTheArm(const KnownRobot& known);

}  // namespace sagitta
