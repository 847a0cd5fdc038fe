// Fit -> noise -> fit: noise that is estimated instead of stated.
//
//   {from: variance-components}, repeatability_urad: estimate    REML (variance_components.h)
//   {from: residuals, …}                                          spread of groups, eq. (14) (residual_noise.h)
//   loss: huber | cauchy                                          reweighting (robust.h), outliers
//   weights: eq14                                                 stated sigmas, weighted by eq. (14)
//
// Each round fits at the noise of the round before and finds the noise at that fit,
// until the noise stands still: then REML holds at the optimum it belongs to. A loop
// that does not settle is said so (NoiseReport::converged) and warned of.
#pragma once

#include "estimator/calibration/joint_estimator.h"

namespace sagitta {

// Something of the noise is to be found by fitting.
bool FindsNoise(const CalibrationProblem& problem);

struct ResolvedEstimate {
  CalibrationProblem problem;  // with the noise that was found; outliers excluded: judge and refit with this one
  Estimate estimate;           // with its NoiseReport
  std::shared_ptr<const RowBatches> rows;  // that were fitted; null where they are not at hand
};

// As EstimateJointly where the noise is stated.
ResolvedEstimate EstimateWithNoise(CalibrationProblem problem, const JointOptions& options = {});

}  // namespace sagitta
