// Fits that do not weigh by the inverse of the noise: `weights: equal` and `weights: eq14`.
//
//   theta minimises sum |W (predicted - measured)|^2
//   W = I / s      equal: ordinary least squares; s common, the root mean square of the noise (it cancels)
//   W = 1 / (s0 + lambda sigma)   eq. (14) of paper 003, per axis
//
//   C = N^-1 J'W^2 S^2 W^2 J N^-1,   N = J'W^2 J   (J not whitened)      eq. (11); equal: eq. (8)
//
// S is the root of the known noise: the estimate is made with W, and judged by S. The
// misfit is tested by the least chi-square that S allows near the estimate,
// |S^-1 r|^2 less what a step of weighted least squares would still gain: that is
// chi-square distributed whatever W was.
#pragma once

#include "estimator/least_squares/linearization.h"

namespace sagitta {

// The noise is stated and the experiment weighs otherwise. False where all roots are alike, too: equal weights then are
// those of the noise.
bool WeighsOtherwise(const CalibrationProblem& problem);
// The same of these observations alone.
bool WeighsOtherwise(const CalibrationProblem& problem, const std::vector<int>& observations);

// Weights of eq. (14), from stated sigmas or from residuals: they are not the inverse of a noise.
bool WeighsByEq14(const Experiment& experiment);

// One root per observation of the data. `noise`: what it scatters by.
NoiseRoots RootsOfWeights(const Experiment& experiment, const NoiseRoots& noise);

// The covariance of what is estimated at `parameters`, SI, where weights are not the inverse of the noise: `solution`
// is that of the fit. Priors have unit variance.
Eigen::MatrixXd CovarianceOfWeighted(const CalibrationProblem& problem, const ParameterSet& parameters,
                                     const LinearSolution& solution);

}  // namespace sagitta
