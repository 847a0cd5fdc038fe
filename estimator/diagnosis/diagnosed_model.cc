#include "estimator/diagnosis/diagnosed_model.h"

#include <cmath>

#include "estimator/least_squares/linearization.h"

namespace sagitta {

Eigen::Matrix3Xd HoldoutMisfit(const DiagnosedModel& model) {
  const Measurements& data = model.problem->data();
  const std::vector<int> held_out = data.PointsAmong(model.problem->ValidationObservations());
  const Eigen::Matrix3Xd& known = model.estimate.predicted;
  const Eigen::Matrix3Xd predicted = known.size() > 0
                                         ? Eigen::Matrix3Xd(known(Eigen::all, held_out))
                                         : PredictPoints(*model.problem, model.estimate.parameters, held_out);
  Eigen::Matrix3Xd misfit(3, predicted.cols());
  for (long k = 0; k < misfit.cols(); ++k) {
    misfit.col(k) = data.observations[held_out[static_cast<size_t>(k)]].point_in_station - predicted.col(k);
  }
  return misfit;
}

DiagnosedModel PredictingHoldout(DiagnosedModel model) {
  Eigen::Matrix3Xd& predicted = model.estimate.predicted;
  if (!IsUsable(model.estimate.status) || predicted.size() > 0) return model;
  const std::vector<int> held_out = model.problem->data().PointsAmong(model.problem->ValidationObservations());
  predicted.setConstant(3, static_cast<long>(model.problem->data().observations.size()), std::nan(""));
  predicted(Eigen::all, held_out) = PredictPoints(*model.problem, model.estimate.parameters, held_out);
  return model;
}

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
