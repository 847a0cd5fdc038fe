// A model under diagnosis: the problem with its effects, and its fit.
#pragma once

#include <memory>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/diagnosis/quick_refit.h"

namespace sagitta {

struct DiagnosedModel {
  std::shared_ptr<CalibrationProblem> problem;
  Estimate estimate;
};

// Measured minus predicted, m, one column per point that was held out (Measurements::PointsAmong): as the estimate has
// predicted it where it has.
Eigen::Matrix3Xd HoldoutMisfit(const DiagnosedModel& model);
// With a prediction of these points, where the model is asked for them several times.
DiagnosedModel PredictingHoldout(DiagnosedModel model);

// The full estimator from the problem's own starting values.
DiagnosedModel FitFully(const CalibrationProblem& problem, const JointOptions& options);

// The full estimator from a nearby point: intervals, identifiability, hold-out. aligned: what results compare with; in
// the end the model before anything was fitted.
DiagnosedModel JudgeFully(std::shared_ptr<CalibrationProblem> problem, const ParameterSet& from,
                          const ParameterSet& aligned, const JointOptions& options);

// A problem that has changed a little, from an estimate of what it was.
DiagnosedModel RefitFully(const CalibrationProblem& problem, const Estimate& start, const JointOptions& options);

// What a quick refit says: parameters, chi-square, degrees of freedom, and whether it converged.
Estimate QuickEstimate(const QuickRefit& refit);

}  // namespace sagitta
