// The intervals an experiment asks for (`covariance`): model and sandwich come
// with every estimate (ComputeStatistics), bootstrap and profile cost refits and are
// added here, once, to the estimate that is handed out.
#pragma once

#include <functional>
#include <string>

#include "estimator/baselines/compare_methods.h"
#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct IntervalOptions {
  int num_threads = 1;
  std::function<void(const std::string&)> progress;  // may be empty
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const IntervalOptions& options);

// Throws InputError where the method cannot honour what the problem states (MethodObstacle), or where intervals from
// refits, which are of the joint estimate, are asked for another method's.
void CheckMethod(const CalibrationProblem& problem, Method method);

void AddIntervals(const CalibrationProblem& problem, const IntervalOptions& options, Estimate* estimate);

}  // namespace sagitta
