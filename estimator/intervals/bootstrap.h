// Intervals from refits of data drawn anew.
//
//   parametric      measurements simulated at the estimate with the stated noise
//                   and repeatability (scaled where the fit says so)
//   configurations  whole configurations drawn with replacement: no noise model
//
// Either way the intervals are studentised: with t* = (theta* - theta_hat) / sigma*
// of the refits, the interval is theta_hat - t*_hi sigma .. theta_hat - t*_lo sigma
// (Efron and Tibshirani 1993, ch. 12). Percentile intervals of few configurations
// cover too little. sigma is the model's for the parametric kind, the sandwich's
// without small-sample factor for the other (the same in refits and original).
// Where refits end at a physical bound the interval holds the model's too.
#pragma once

#include <functional>
#include <string>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct BootstrapOptions {
  BootstrapKind kind = BootstrapKind::kAutomatic;
  int replicates = 999;
  unsigned long long seed = 1;
  int num_threads = 1;
  std::function<void(const std::string&)> progress;  // may be empty
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const BootstrapOptions& options);

// Replaces covariance, intervals and table of a judged estimate. Throws
// InputError where configurations are asked for and too few to be resampled.
void BootstrapIntervals(const CalibrationProblem& problem, const BootstrapOptions& options, Estimate* estimate);

}  // namespace sagitta
