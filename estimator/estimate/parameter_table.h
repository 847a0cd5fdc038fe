// The result table: one line per coordinate, with its interval.
#pragma once

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Degrees of freedom of an interval by the model's covariance: those of the fit
// where the noise is estimated or scaled, infinity where it is assumed to be as stated.
double ModelDof(const Estimate& estimate);

// Fills estimate->table from parameters, covariance, dof and held influence;
// intervals value -+ t sigma, cut at the physical bound.
void FillTable(const CalibrationProblem& problem, Estimate* estimate);

// Whether what held parameters add to a variance is worth a word.
bool IsWidened(double sigma, double added);

// Whether the interval's arms are alike, so that one figure says both.
bool IsEven(const ParameterEstimate& row);

// The noise that the estimate goes by over the one that rows were whitened with: covariances are multiplied by its
// square.
double AppliedNoise(const SigmaReport& sigma);

}  // namespace sagitta
