// Everything that is fitted as one cost of Ceres: residuals and Jacobian of Condense(NormalEquations), columns + 1
// rows whatever the number of observations. Cost, gradient and Gauss-Newton model are those of all rows, so that
// Ceres keeps blocks, manifolds, bounds and steps while the rows are summed in one pass.
#pragma once

#include <ceres/problem.h>

#include "estimator/least_squares/minimize.h"
#include "estimator/least_squares/normal_equations.h"

namespace sagitta {

// Adds that cost over all blocks with an estimated coordinate; the blocks are the memory of `parameters`. Priors and
// the spring tie are inside. `equations` and `parameters` must outlive the problem.
void AddCondensed(const NormalEquations& equations, ParameterSet* parameters, ceres::Problem* ceres_problem);

// Levenberg-Marquardt on it, as MinimizeJointly but for joints, whose deviations are as the equations have them.
MinimizeSummary MinimizeSums(const NormalEquations& equations, const MinimizeOptions& options,
                             ParameterSet* parameters);

}  // namespace sagitta
