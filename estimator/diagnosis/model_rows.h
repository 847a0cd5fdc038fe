// The whitened rows of a fitted model, and how joints that deviate move them.
#pragma once

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {

// Its fitted rows for the estimated coordinates.
Linearization LinearizeEstimate(const CalibrationProblem& problem, const ParameterSet& parameters,
                                LatentTreatment treatment = LatentTreatment::kMarginalise);

// How a deviation of each joint on its encoder side moves the same rows, per urad (um); one column per joint.
Eigen::MatrixXd JointDeviationColumns(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      LatentTreatment treatment = LatentTreatment::kMarginalise);

}  // namespace sagitta
