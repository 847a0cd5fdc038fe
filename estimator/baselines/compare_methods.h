// Methods side by side on one problem: what each makes of the same data, measured
// against the joint estimate.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct MethodResult {
  std::string name;
  Estimate estimate;
  double max_deviation_sigma = 0.0;  // from the joint optimum, in its standard deviations; NaN: no estimate
  double rate_measured = 0.0;        // of the alternation; NaN: none
  double rate_predicted = 0.0;       // c1^2 at the joint optimum, two-step only; NaN: none
};

// joint, two-step, two-step-literal, two-step-relinearised, full-pose, differencing.
const std::vector<std::string>& MethodNames();

// Why a method cannot honour the noise of the problem (joint deviations, full covariances, estimated noise, a loss);
// empty: it can. The literal methods of the papers know sigmas per axis only.
std::string MethodObstacle(const CalibrationProblem& problem, const std::string& method);

// `method` is one of MethodNames(). `joint` is the joint estimate of the problem:
// what it held is held by every method, at the same values. Judge a method by
// estimate.status: one that cannot run on the data says so there.
MethodResult RunMethod(const CalibrationProblem& problem, const std::string& method, const Estimate& joint,
                       const std::function<void(const std::string&)>& progress = {});

}  // namespace sagitta
