// Which coordinates of a problem are free: what the experiment asks for, and what the default is.
#pragma once

#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// Joints whose compliance is asked for; by default all of them where rows are
// loaded (what a load does not excite is held later, with words).
std::vector<std::string> CompliantJoints(const Robot& robot, const Measurements& data, const Experiment& experiment);

// Joints that are to be estimated start rigid where the file states nothing.
Robot WithCompliances(Robot robot, const std::vector<std::string>& joints);

// Marks every coordinate free or held; notes which errors stay nominal.
void SetFree(CalibrationProblem* problem);

}  // namespace sagitta
