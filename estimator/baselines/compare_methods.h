// Methods side by side on one problem: what each makes of the same data, measured
// against the joint estimate.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"
#include "problems/choices.h"

namespace sagitta {

// The joint estimate, the papers' two halves (exact; as published; linearised anew), poses fitted to the markers of
// each shot, differences of loaded rows.
enum class Method { kJoint, kTwoStep, kTwoStepLiteral, kTwoStepRelinearised, kFullPose, kDifferencing };
// "joint", "two-step", ...
std::string WordOf(Method method);

// What one method made of the data.
struct MethodResult {
  std::string name;
  Estimate estimate;
  double max_deviation_sigma = 0.0;  // from the joint optimum, in its standard deviations; NaN: no estimate
  double rate_measured = 0.0;        // of the alternation; NaN: none
  double rate_predicted = 0.0;       // c1^2 at the joint optimum, two-step only; NaN: none
};

// The method that a word names; `key`: where the word was given. Throws InputError where it names none.
Method MethodNamed(const std::string& word, const std::string& key = "--method");

// Why a method cannot honour the noise of the problem (joint deviations, full covariances, estimated noise, a loss);
// empty: it can. The literal methods of the papers know sigmas per axis only.
std::string MethodObstacle(const CalibrationProblem& problem, Method method);

// `joint` is the joint estimate of the problem:
// what it held is held by every method, at the same values. Judge a method by
// estimate.status: one that cannot run on the data says so there.
MethodResult RunMethod(const CalibrationProblem& problem, Method method, const Estimate& joint,
                       const std::function<void(const std::string&)>& progress = {});

}  // namespace sagitta
