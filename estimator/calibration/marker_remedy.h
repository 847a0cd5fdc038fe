// Which marker would determine the errors that those at hand do not see: one on the axis of the last joint shows no
// turn about it, however far the joints move.
#pragma once

#include <optional>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// The last joint that turns, where every marker that it moves is on its axis; nothing where one is off it.
std::optional<int> AxisOfAllMarkers(const CalibrationProblem& problem, const ParameterSet& parameters);

// Fills Direction::remedy of the unidentifiable directions of geometric errors alone that such a marker leaves open.
void AddMarkerRemedies(const CalibrationProblem& problem, Estimate* estimate);

}  // namespace sagitta
