// Whether the members of a problem that its owner may set fit together, which none of the loops behind looks at again.
#pragma once

#include "problems/calibration_problem.h"

namespace sagitta {

// That parameters are those of the problem's stations, markers and model, with values that are numbers (rotations: unit
// quaternions), that priors, bounds and limits are numbers, that joints' deviations belong to its shots and roots of
// the noise to its rows. Throws std::invalid_argument that begins with `function`, the entry that was called, and
// InputError where the experiment cannot be used (experiment_checks.h).
void CheckIsWhole(const CalibrationProblem& problem, const char* function);

}  // namespace sagitta
