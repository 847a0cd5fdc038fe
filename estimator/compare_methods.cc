#include "estimator/compare_methods.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/canonical_rate.h"
#include "estimator/ceres_problem.h"
#include "estimator/differencing.h"
#include "estimator/full_pose.h"
#include "estimator/two_step.h"

namespace sagitta {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// The problem with the joint decision of what to hold, and where.
CalibrationProblem WithHeld(const CalibrationProblem& problem, const Estimate& joint) {
  CalibrationProblem result = problem;
  if (!IsUsable(joint.status)) return result;
  result.parameters = joint.aligned;
  for (int i = 0; i < result.parameters.num_coordinates(); ++i) {
    result.parameters.coordinate(i).held = joint.parameters.coordinates()[i].held;
  }
  return result;
}

double LargestDeviation(const Estimate& estimate, const Estimate& joint) {
  if (!IsUsable(estimate.status) || !IsUsable(joint.status)) return kNone;
  const Eigen::VectorXd difference = TangentDifference(estimate.parameters, joint.parameters);
  double largest = 0.0;
  for (const int c : joint.estimated) largest = std::max(largest, std::abs(difference[c]) / joint.table[c].sigma);
  return largest;
}

double PredictedRate(const CalibrationProblem& problem, const Estimate& joint) {
  if (!IsUsable(joint.status)) return kNone;
  const ResidualSelection residuals = CalibrationResiduals(problem);
  return PredictTwoStepRate(
      Linearize(problem, joint.parameters, residuals.observations, joint.estimated, residuals.noise), joint.parameters);
}

}  // namespace

const std::vector<std::string>& MethodNames() {
  static const std::vector<std::string> names = {
      "joint", "two-step", "two-step-literal", "two-step-relinearised", "full-pose", "differencing"};
  return names;
}

std::string MethodObstacle(const CalibrationProblem& problem, const std::string& method) {
  if (method == "joint") return "";
  if (problem.experiment.loss != "none") return method + " knows no robust loss";
  if (method == "two-step") return "";  // exact halves whiten as the joint estimate does
  if (!problem.latent.empty() || problem.experiment.repeatability.estimate) {
    return method + " knows no joint deviations (repeatability)";
  }
  if (!IsDiagonal(CalibrationResiduals(problem).noise)) {
    return method + " knows standard deviations per axis, not an instrument's covariances";
  }
  return "";
}

MethodResult RunMethod(const CalibrationProblem& problem, const std::string& method, const Estimate& joint,
                       const std::function<void(const std::string&)>& progress) {
  MethodResult result{method, {}, kNone, kNone, kNone};
  const std::string obstacle = MethodObstacle(problem, method);
  if (method == "joint") {
    result.estimate = joint;
  } else if (!obstacle.empty()) {
    result.estimate.parameters = result.estimate.aligned = problem.parameters;
    result.estimate.message = "not run: " + obstacle;
  } else if (method == "full-pose") {
    result.estimate = EstimateFromFullPoses(WithHeld(problem, joint));
  } else if (method == "differencing") {
    result.estimate = EstimateByDifferencing(WithHeld(problem, joint), progress);
  } else {
    TwoStepOptions options;
    options.progress = progress;
    if (method == "two-step-literal")
      options.variant = TwoStepVariant::kLiteral;
    else if (method == "two-step-relinearised")
      options.variant = TwoStepVariant::kRelinearised;
    else
      CHECK_EQ(method, "two-step") << "no such method";
    TwoStepResult two_step = EstimateInTwoSteps(WithHeld(problem, joint), options);
    result.estimate = std::move(two_step.estimate);
    result.rate_measured = two_step.rate;
    if (method == "two-step") result.rate_predicted = PredictedRate(problem, joint);
  }
  if (IsUsable(result.estimate.status)) {
    result.estimate.identifiability.unidentifiable = joint.identifiability.unidentifiable;
  }
  result.max_deviation_sigma = LargestDeviation(result.estimate, joint);
  return result;
}

}  // namespace sagitta
