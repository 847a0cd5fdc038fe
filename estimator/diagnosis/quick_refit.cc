#include "estimator/diagnosis/quick_refit.h"

#include "estimator/least_squares/refit.h"

namespace sagitta {

// The step that is left is taken without looking again: at a hundredth of a standard deviation its own chi-square, by
// the quadratic model, is good to 1e-4 even where effects bend.
QuickRefit RefitQuickly(const CalibrationProblem& problem, const ParameterSet& start) {
  RefitOptions options;
  options.steps.max_steps = 40;  // most need two or three
  options.steps.tolerance = 0.01;
  options.steps.least_noise = 1.0;  // as stated
  Refit found = RefitFrom(problem, start, options);
  QuickRefit refit;
  refit.converged = found.converged;
  refit.parameters = std::move(found.parameters);
  if (!found.converged) return refit;
  const Linearization& here = found.linearization;
  refit.chi2 = (here.residual + here.jacobian * found.left.delta).squaredNorm();
  refit.rows = found.equations;
  refit.dof = found.equations - here.num_columns() + static_cast<int>(found.left.pinned.size());
  refit.sigmas.setZero(refit.parameters.num_coordinates());
  refit.sigmas(here.columns) = found.left.root.rowwise().norm();
  Move(here.columns, found.left.delta, 1.0, &refit.parameters);
  return refit;
}

}  // namespace sagitta
