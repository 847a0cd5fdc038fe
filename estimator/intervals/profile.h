// Profile-likelihood intervals: an end of the interval is where the best fit with
// the parameter kept there is worse by what chance allows,
//
//   min over the others of chi2(theta_i) - chi2_min = t^2 s^2,
//
// t the quantile of the model's interval, s^2 the noise scale. No ellipse is
// assumed: what bends (compensator geometry, compliances near zero) is followed,
// bounds included. Each end is a root in one dimension, started at the ellipse's
// end and warm-started from the fit before.
#pragma once

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct ProfileOptions {
  int num_threads = 1;
  double tolerance = 1e-3;  // of t
  double farthest = 30.0;   // half-widths of the ellipse's interval; beyond: open
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const ProfileOptions& options);

// Replaces ci95 of every estimated coordinate of a judged estimate; covariance and
// sigma stay the model's. An end that does not close is marked open.
void ProfileIntervals(const CalibrationProblem& problem, const ProfileOptions& options, Estimate* estimate);

}  // namespace sagitta
