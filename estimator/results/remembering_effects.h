// Effects of a known robot that go with what was done before: play that a way leaves, heat, a body that follows its
// thermometer late.
#pragma once

#include <string>
#include <vector>

namespace sagitta {

struct KnownRobot;

// Paths (EffectSpec::Path) of those that act, in the robot's order.
std::vector<std::string> RememberingEffects(const KnownRobot& known);

}  // namespace sagitta
