// Where what is left lies: over what may drive it, and in the workspace.
#pragma once

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"
#include "tools/report/picture.h"

namespace sagitta {

// measured - predicted of every point over each joint, its torque, time, temperature and order: chosen by menu.
Picture ResidualsOverDrivers(const CalibrationProblem& problem, const Estimate& estimate);

// The same as arrows where the points are, in the base frame, with the arm in the selected pose.
Picture ResidualsInWorkspace(const CalibrationProblem& problem, const Estimate& estimate);

}  // namespace sagitta
