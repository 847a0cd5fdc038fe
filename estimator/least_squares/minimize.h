// Levenberg-Marquardt by Ceres over the coordinates that are estimated.
#pragma once

#include <string>

#include "estimator/least_squares/ceres_problem.h"

namespace sagitta {

struct MinimizeOptions {
  int max_iterations = 100;
  int num_threads = 1;
  // For starting values: small steps, because the problem may be rank
  // deficient, and joints assumed to be exact. Otherwise the first step is
  // Gauss-Newton (4-5 iterations from nominal).
  bool cautious = false;
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const MinimizeOptions& options);

// How a solve went.
struct MinimizeSummary {
  bool usable = false;  // pessimistic until Ceres says otherwise
  bool converged = false;
  int iterations = 0;
  double initial_cost = 0.0;  // 1/2 sum r^2
  double final_cost = 0.0;
  double seconds = 0.0;
  std::string message = "not run";
};

// Moves `parameters` to the optimum of the selected residuals; deviations of joints are estimated along.
MinimizeSummary MinimizeJointly(const CalibrationProblem& problem, const ResidualSelection& selection,
                                const MinimizeOptions& options, ParameterSet* parameters);

}  // namespace sagitta
