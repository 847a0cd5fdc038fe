#include "estimator/diagnosis/diagnosed_model.h"

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

Estimate QuickEstimate(const QuickRefit& refit) {
  Estimate estimate;
  if (refit.converged) estimate.status = Status::kConverged;
  estimate.parameters = refit.parameters;
  estimate.chi2 = refit.chi2;
  estimate.rows = refit.rows;
  estimate.dof = refit.dof;
  return estimate;
}

}  // namespace sagitta
