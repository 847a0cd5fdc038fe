#include "estimator/diagnosis/diagnosed_model.h"

#include "estimator/least_squares/refit.h"

namespace sagitta {

DiagnosedModel FitFully(const CalibrationProblem& problem, const JointOptions& options) {
  DiagnosedModel model;
  model.problem = std::make_shared<CalibrationProblem>(problem);
  model.estimate = EstimateJointly(*model.problem, options);
  return model;
}

DiagnosedModel JudgeFully(std::shared_ptr<CalibrationProblem> problem, const ParameterSet& from,
                          const ParameterSet& aligned, const JointOptions& options) {
  DiagnosedModel judged;
  judged.problem = std::move(problem);
  JointOptions near = options;
  near.aligned = &aligned;
  judged.estimate = EstimateFrom(*judged.problem, from, near);
  return judged;
}

DiagnosedModel RefitFully(const CalibrationProblem& problem, const Estimate& start, const JointOptions& options) {
  return JudgeFully(std::make_shared<CalibrationProblem>(problem), start.parameters, start.aligned, options);
}

// The step that is left is made without looking again: at a hundredth of a standard deviation its own chi-square, by
// the quadratic model, is good to 1e-4 even where effects bend.
QuickRefit RefitQuickly(const CalibrationProblem& problem, const ParameterSet& start) {
  RefitOptions options;
  options.steps.max_steps = 40;  // most need two or three
  options.steps.tolerance = 0.01;
  options.steps.least_noise = 1.0;  // as stated
  Refit found = RefitFrom(problem, start, options);
  QuickRefit refit;
  Estimate& estimate = refit.estimate;
  estimate.parameters = std::move(found.parameters);
  if (!found.converged) return refit;
  const Linearization& here = found.linearization;
  estimate.status = Status::kConverged;
  estimate.chi2 = (here.residual + here.jacobian * found.left.delta).squaredNorm();
  estimate.rows = found.equations;
  estimate.dof = found.equations - here.num_columns() + static_cast<int>(found.left.pinned.size());
  refit.sigmas.setZero(estimate.parameters.num_coordinates());
  refit.sigmas(here.columns) = found.left.root.rowwise().norm();
  Move(here.columns, found.left.delta, 1.0, &estimate.parameters);
  return refit;
}

}  // namespace sagitta
