// What one unit of a parameter moves where the rows excite it most, and the limits of held directions that follow.
#pragma once

#include <functional>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// The largest among the calibration rows, by model parameter: rad or m per SI unit (models/excitation.h), at these
// values. 0 where it is less than what a rotation of the base that the data do not determine (5 mrad) would change: a
// load along a joint's axis makes no torque about it; and 0 where it is the round-off of what the effect's other
// parameters move.
std::vector<double> LargestTrueMotions(const CalibrationProblem& problem, const ParameterSet& parameters);

// Sets Coordinate::hold_limit of compliances, effects and the spring's rate: 5 mm or 5 mrad of what it moves. That of
// geometric errors, points, poses and lengths is of their kind; so is that of a parameter which no row excites at all.
void SetHoldLimits(const CalibrationProblem& problem, ParameterSet* parameters);

// The largest motions among the calibration rows at each of some values, as above but as they are; of geometric errors
// any number.
using LargestMotionsAt = std::function<std::vector<std::vector<double>>(const std::vector<ParameterSet>& at)>;
// The same limits where motions are found otherwise. some: those among some of many rows, or empty. Where these show
// that a rotation of the base does not make them, the others are not asked about that.
void SetHoldLimits(const CalibrationProblem& problem, const LargestMotionsAt& largest, const LargestMotionsAt& some,
                   ParameterSet* parameters);

}  // namespace sagitta
