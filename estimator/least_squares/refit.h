// Refits from a solution nearby: other data, other weights, one coordinate kept. A few steps (gauss_newton.h) where
// the optimum is a few standard deviations away.
#pragma once

#include <vector>

#include "estimator/least_squares/gauss_newton.h"

namespace sagitta {

struct RefitOptions {
  std::vector<double> weights;  // of each calibration observation: how often it counts; empty: once
  int kept = -1;                // a coordinate that stays where the start has it
  GaussNewtonOptions steps;
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const RefitOptions& options);

struct Refit {
  bool converged = false;
  ParameterSet parameters;
  // At the optimum, rows times the root of their weight; where they are too many to be kept (AreHeld, row_sums.h) as
  // few as there are columns with the same sums.
  Linearization linearization;
  int equations = 0;  // that its rows stand for
  BoundedStep left;   // what is below the tolerance; its root W: W W' = (J'J)^-1
  double chi2 = 0.0;  // at the optimum
};

// Estimates what `start` estimates, beginning there.
Refit RefitFrom(const CalibrationProblem& problem, const ParameterSet& start, const RefitOptions& options = {});

// Whitened rows of everything that is fitted, priors included, at `parameters`.
Linearization LinearizeFit(const CalibrationProblem& problem, const ParameterSet& parameters,
                           const std::vector<int>& columns);

}  // namespace sagitta
