// How much of chi-square is the pull of stated priors.
#pragma once

#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/linearization.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// fitted: rows, priors among them, at the estimate, by the noise that is judged; sum: their chi-square with `dof`
// degrees of freedom. Where priors add more to it than chance, at the noise that the rows alone show, leaves to both
// what is the rows' own; fills estimate->sigma.pull.
void SetPriorsAside(const CalibrationProblem& problem, const Linearization& fitted, double* sum, double* dof,
                    Estimate* estimate);

}  // namespace sagitta
