// Whether a robot that is written moves as the one that was read, whatever its description.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/robot.h"

namespace sagitta {

// The largest distance of the bare chains' flanges and of points 1 m from them, m, over random joint values.
double LargestDifference(const Chain& a, const Chain& b, std::uint64_t seed);

// An effect whose values move the flange of the written robot otherwise: they count from axes of the joint's own frame,
// and those of the other description are not the same.
struct EffectInOtherFrame {
  std::string path;       // EffectSpec::Path
  double distance = 0.0;  // m, the largest of points 1 m from the flange, over random poses with 1 kN on the flange
};
// Both robots have the same effects in the same order.
std::vector<EffectInOtherFrame> EffectsInOtherFrames(const Robot& read, const Robot& written, std::uint64_t seed);

}  // namespace sagitta
