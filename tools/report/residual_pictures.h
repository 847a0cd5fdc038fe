// Where what is left lies: over what may drive it, and in the workspace.
#pragma once

#include "tools/report/picture.h"
#include "tools/report/residual_rows.h"

namespace sagitta {

// measured - predicted of every point over each joint, its torque, time, temperature and order: chosen by menu.
Picture ResidualsOverDrivers(const DrawnReadings& readings);

// The same as arrows where the points are, in the base frame, with the arm in the selected pose.
Picture ResidualsInWorkspace(const DrawnReadings& readings);

}  // namespace sagitta
