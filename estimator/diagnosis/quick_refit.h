// A cheap refit for choosing among effects, from a nearby optimum. Effects are nearly linear, so that a few steps do;
// where they do not, `converged` is false and the full estimator has to say. What was held stays held.
#pragma once

#include "problems/calibration_problem.h"

namespace sagitta {

struct QuickRefit {
  bool converged = false;
  double chi2 = 0.0;  // priors included
  int rows = 0;
  int dof = 0;
  ParameterSet parameters;
  Eigen::VectorXd sigmas;  // per coordinate of `parameters`, SI, at the stated noise; 0 unless estimated
};

// Estimates what `start` estimates, beginning there.
QuickRefit RefitQuickly(const CalibrationProblem& problem, const ParameterSet& start);

}  // namespace sagitta
