// Centres of gravity of loads that are of another mass than stated, too. load_com is the moment d x F of the stated
// force, payload a force dm g at the stated point p:
//
//   (p + d) x m g + p x dm g = (p + d m / (m + dm)) x (m + dm) g
#pragma once

#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// A sentence for each load with both effects, with its centre of gravity.
std::vector<std::string> LoadCentresInWords(const CalibrationProblem& problem, const ParameterSet& parameters);

}  // namespace sagitta
