// Joints that follow others by a stated coupling: of the command, as a controller computes it.
#pragma once

#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// A sentence for each joint that follows one that gives way to loads; all: whichever it follows.
std::vector<std::string> WarningsOfCouplings(const CalibrationProblem& problem, bool all = false);

}  // namespace sagitta
