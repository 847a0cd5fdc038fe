// Sequences of elementary transforms: Tz(0.4) Rz(q1) Rx(-90) … (DHFactor's input, ETS).
#pragma once

#include <string>

#include "problems/io/import/robot_reading.h"

namespace sagitta {

// At least two transforms are in the text.
bool HoldsElementaryTransforms(const std::string& text);

// Nothing of the text is left out: whatever is no transform, no sign of a product and no
// comment is refused by its line. Throws InputError.
RobotReading ReadElementaryTransforms(const std::string& text, const std::string& path);

}  // namespace sagitta
