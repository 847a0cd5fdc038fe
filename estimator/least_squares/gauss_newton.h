// The one Gauss-Newton of everything that refits: from values nearby to the optimum inside the bounds.
//
//   d = argmin |J d + r|^2 + damping |D d|^2    so that   value + d >= lower,    D: norms of the columns of J
//
// Undamped as long as the cost falls, or the steps halve near it; a step that raises it otherwise is tried again with
// more damping (Levenberg, Marquardt).
// The joint problem itself is solved by Ceres (minimize.h, condensed_cost.h).
#pragma once

#include <functional>
#include <vector>

#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/normal_equations.h"

namespace sagitta {

// Whitened rows of everything that is fitted, priors included, at some values: one column per listed coordinate.
using RowsAt = std::function<FittedRows(const ParameterSet& parameters, const std::vector<int>& columns)>;

enum class StepOutcome { kTaken, kSingular, kNoDescent, kEquilibriumDiverged };

struct GaussNewtonOptions {
  int max_steps = 30;  // quadratic convergence needs a few; a bent valley halves what is left: 2^-30 = 1e-9
  // Of the step that is left, in standard deviations: far below what any interval shows; convergence is quadratic, and
  // what comes after is 1e-8.
  double tolerance = 1e-4;
  double least_noise = 1e-9;  // the noise seen counts as no less, whitened: data without noise end at round-off
};

// What a refit ends with; pessimistic until it has converged.
struct GaussNewtonResult {
  bool converged = false;
  StepOutcome outcome = StepOutcome::kEquilibriumDiverged;  // of the last step
  int steps = 0;
  ParameterSet parameters;
  FittedRows fitted;  // there
  BoundedStep left;   // the undamped step from there, and the root of the covariance

  double cost() const { return fitted.rows.residual.squaredNorm(); }  // chi-square
};

// Moves `columns` (coordinates), the others held.
GaussNewtonResult GaussNewton(const RowsAt& rows_at, const std::vector<int>& columns, const ParameterSet& start,
                              const GaussNewtonOptions& options = {});

// One step from `parameters`, where the rows are `here`, for methods that alternate. A step that promises less than a
// thousandth of the cost is made without looking whether the cost falls.
StepOutcome TakeOneStep(const RowsAt& rows_at, const Linearization& here, ParameterSet* parameters);

}  // namespace sagitta
