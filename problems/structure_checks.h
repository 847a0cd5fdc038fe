// Whether robot and rows fit together as structures: what readers of files see to, and callers with data in memory may
// get wrong. Behind this check every index leads somewhere and every number is one.
#pragma once

#include "models/robot.h"
#include "problems/measurements.h"

namespace sagitta {

// Rows that name no marker are of the flange: targets (problems/io/target_file.h).
enum class MarkerlessRows { kRefused, kAllowed };

// Throws InputError that names the joint, effect, configuration, shot or row. Points and rotations may be NaN: not
// measured (CheckRowsAreRead).
void CheckStructure(const Robot& robot, const Measurements& data, MarkerlessRows markerless = MarkerlessRows::kRefused);

}  // namespace sagitta
