// Loads against what they do: how far the markers move per newton, and whether they give way, and where to.
#pragma once

#include <vector>

#include "estimator/inspection/finding.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Forces in a wrong unit (no arm gives way by a millimetre per newton, none is stiffer than 100 kN/mm) and forces of
// the wrong sign (the markers move against them), or weights in another direction (load_direction.h).
std::vector<Finding> LintDeflections(const CalibrationProblem& problem);

}  // namespace sagitta
