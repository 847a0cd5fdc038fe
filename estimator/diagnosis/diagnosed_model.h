// A model under diagnosis: the problem with its effects, and its fit.
#pragma once

#include <memory>
#include <vector>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/explanations/candidates.h"

namespace sagitta {

struct DiagnosedModel {
  std::shared_ptr<CalibrationProblem> problem;
  Estimate estimate;
};

// The full estimator from the problem's own starting values.
DiagnosedModel FitFully(const CalibrationProblem& problem, const JointOptions& options);

// The full estimator from a nearby point: intervals, identifiability, hold-out. aligned: what results compare with; in
// the end the model before anything was fitted.
DiagnosedModel JudgeFully(std::shared_ptr<CalibrationProblem> problem, const ParameterSet& from,
                          const ParameterSet& aligned, const JointOptions& options);

// A problem that has changed a little, from an estimate of what it was.
DiagnosedModel RefitFully(const CalibrationProblem& problem, const Estimate& start, const JointOptions& options);

// A cheap refit for choosing among effects, from a nearby optimum. Effects are nearly linear, so that a few steps do;
// where they do not, the status is not usable and the full estimator has to say. What was held stays held.
struct QuickRefit {
  Estimate estimate;       // status, parameters, chi-square (priors included), rows, degrees of freedom
  Eigen::VectorXd sigmas;  // per coordinate of the parameters, SI, at the stated noise; 0 unless estimated
};
// Estimates what `start` estimates, beginning there.
QuickRefit RefitQuickly(const CalibrationProblem& problem, const ParameterSet& start);

// Its estimated parameters in the table of an estimate. Their intervals allow for what is held, as those that people
// read of a calibration do: the believed model holds what its data do not determine, whatever the effect makes of it.
std::vector<ParameterEstimate> ParameterRowsOf(const EffectSpec& spec, const Estimate& estimate);

// Refitted from the model's own optimum, what the data determine poorly of these effects (Candidate::loose) with its
// widest prior: parameters, chi-square and degrees of freedom, by Gauss-Newton where that converges and nothing becomes
// so uncertain that it has to be held. What is reported comes from JudgeFully.
DiagnosedModel Extend(const DiagnosedModel& model, const std::vector<Candidate>& added, const JointOptions& options);

}  // namespace sagitta
