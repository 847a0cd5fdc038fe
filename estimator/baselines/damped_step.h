// One Gauss-Newton step of the baselines: damped until the cost falls, and inside the bounds.
#pragma once

#include <functional>
#include <vector>

#include "estimator/least_squares/linearization.h"

namespace sagitta {

enum class StepOutcome { kTaken, kSingular, kNoDescent, kEquilibriumDiverged };
// "a step's linear system is singular", ...
const char* StepOutcomeInWords(StepOutcome outcome);

// Whitened rows at some values, one column per listed coordinate.
using RowsAt = std::function<Linearization(const ParameterSet& parameters, const std::vector<int>& coordinates)>;

// Moves `coordinates`, the others held. A column of zeros (a spring on a joint that is still rigid) waits; a
// coordinate on its bound whose gradient points outside stays there. A step that explains little of the cost is
// taken as it is; a far one is damped until the cost does fall (springs and loads overshoot).
StepOutcome DampedStep(const RowsAt& rows_at, const std::vector<int>& coordinates, ParameterSet* parameters);

}  // namespace sagitta
