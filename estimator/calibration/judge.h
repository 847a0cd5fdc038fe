// Step 4 of the joint estimator where the equations of its fit are at hand: what they have put side by side is not put
// together anew.
#pragma once

#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/normal_equations.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// equations: of what was fitted, as the fit weighs it, deviations of joints marginalised.
void ComputeStatistics(const CalibrationProblem& problem, const NormalEquations& equations, Estimate* estimate);

}  // namespace sagitta
