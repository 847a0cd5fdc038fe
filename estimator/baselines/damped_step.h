// One step of a baseline that alternates: Gauss-Newton (gauss_newton.h) in some coordinates, the others held.
#pragma once

#include <vector>

#include "estimator/least_squares/gauss_newton.h"

namespace sagitta {

// A column of zeros (a spring on a joint that is still rigid) waits.
StepOutcome DampedStep(const RowsAt& rows_at, const std::vector<int>& coordinates, ParameterSet* parameters);

}  // namespace sagitta
