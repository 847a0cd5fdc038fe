#include "estimator/baselines/compare_methods.h"

#include <algorithm>
#include <cmath>

#include "estimator/baselines/canonical_rate.h"
#include "estimator/baselines/differencing.h"
#include "estimator/baselines/full_pose.h"
#include "estimator/baselines/two_step.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/ceres_problem.h"
#include "estimator/noise/residual_noise.h"
#include "estimator/report/baselines_words.h"
#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/problem_checks.h"

namespace sagitta {
namespace {

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
  if (!IsUsable(estimate.status) || !IsUsable(joint.status)) return kNotKnown;
  const Eigen::VectorXd difference = TangentDifference(estimate.parameters, joint.parameters);
  double largest = 0.0;
  for (const int c : joint.estimated) largest = std::max(largest, std::abs(difference[c]) / joint.table[c].sigma);
  return largest;
}

// On what is estimated of one kind.
bool HasPriors(const ParameterSet& parameters, CoordinateKind kind) {
  const std::vector<Coordinate>& coordinates = parameters.coordinates();
  return std::any_of(coordinates.begin(), coordinates.end(), [kind](const Coordinate& coordinate) {
    return coordinate.estimated() && coordinate.has_prior() && coordinate.kind == kind;
  });
}

// On anything, the tie of markers to a spring too.
bool HasPriors(const ParameterSet& parameters) {
  const std::vector<Coordinate>& coordinates = parameters.coordinates();
  return parameters.spring_tie() ||
         std::any_of(coordinates.begin(), coordinates.end(),
                     [](const Coordinate& coordinate) { return coordinate.estimated() && coordinate.has_prior(); });
}

// The halves find the joint optimum under the noise that the joint estimate found.
void TakeNoise(const CalibrationProblem& problem, const Estimate& joint, Estimate* estimate) {
  if (joint.noise_report.components.empty()) return;
  estimate->noise_report = joint.noise_report;
  if (joint.interval_dof.size() != estimate->covariance.rows()) return;
  ReplaceCovariance(problem, estimate->covariance, joint.interval_dof, estimate);
}

double PredictedRate(const CalibrationProblem& problem, const Estimate& joint) {
  if (!IsUsable(joint.status)) return kNotKnown;
  const ResidualSelection residuals = FittedResiduals(problem);
  Linearization optimum =
      Linearize(problem, joint.parameters, residuals.observations, joint.estimated, residuals.noise);
  AppendPriors(joint.parameters, &optimum);  // rows of what both halves minimise: they turn the spans apart
  return PredictTwoStepRate(optimum, joint.parameters);
}

}  // namespace

std::string WordOf(Method method) {
  switch (method) {
    case Method::kJoint:
      return "joint";
    case Method::kTwoStep:
      return "two-step";
    case Method::kTwoStepLiteral:
      return "two-step-literal";
    case Method::kTwoStepRelinearised:
      return "two-step-relinearised";
    case Method::kFullPose:
      return "full-pose";
    case Method::kDifferencing:
      return "differencing";
  }
  return "";
}

Method MethodNamed(const std::string& word, const std::string& key) {
  if (const auto method = FindChoice<Method>(word)) return *method;
  throw InputError({"", 0, key}, "there is no method '" + word + "'", SpellingHint(word, WordsOf<Method>()));
}

std::string MethodObstacle(const CalibrationProblem& problem, Method method) {
  const std::string name = WordOf(method);
  if (method == Method::kJoint) return "";
  if (problem.experiment().method.loss != LossKind::kNone) return name + " knows no robust loss";
  if (method == Method::kTwoStep) return "";  // exact halves whiten as the joint estimate does
  const std::vector<bool> oriented = problem.data().OrientedMarkers();
  if (std::find(oriented.begin(), oriented.end(), true) != oriented.end()) {
    return name + " knows measured points, not the rotation of a pose";
  }
  const bool takes_rows_only = method == Method::kFullPose || method == Method::kTwoStepLiteral;
  if (takes_rows_only && HasPriors(problem.parameters)) return name + " knows no priors";
  for (const CoordinateKind kind :
       {CoordinateKind::kBase, CoordinateKind::kMarker}) {  // what its first half solves for
    const bool is_ignored = method == Method::kTwoStepRelinearised && HasPriors(problem.parameters, kind);
    if (is_ignored) return name + " knows no priors of " + WordOf(kind) + "/…";
  }
  if (method == Method::kFullPose && problem.experiment().method.covariance == CovarianceKind::kSandwich)
    return name + " knows no sandwich";
  if (!problem.latent.empty() || problem.experiment().repeatability.IsEstimated()) {
    return name + " knows no joint deviations (repeatability)";
  }
  if (!IsDiagonal(FittedResiduals(problem).noise)) {
    return KnowsAxesOnly(name);
  }
  return "";
}

MethodResult RunMethod(const CalibrationProblem& problem, Method method, const Estimate& joint,
                       const std::function<void(const std::string&)>& progress) {
  CheckRowsAreRead(problem);
  MethodResult result{WordOf(method), {}, kNotKnown, kNotKnown, kNotKnown};
  const std::string obstacle = MethodObstacle(problem, method);
  if (method == Method::kJoint) {
    result.estimate = joint;
  } else if (!obstacle.empty()) {
    result.estimate.parameters = result.estimate.aligned = problem.parameters;
    result.estimate.status = Status::kNotRun;
    result.estimate.message = NotRunBecause(obstacle);
  } else if (method == Method::kFullPose) {
    result.estimate = EstimateFromFullPoses(WithHeld(problem, joint));
  } else if (method == Method::kDifferencing) {
    result.estimate = EstimateByDifferencing(WithHeld(problem, joint), progress);
  } else {
    TwoStepOptions options;
    options.progress = progress;
    if (method == Method::kTwoStepLiteral) options.variant = TwoStepVariant::kLiteral;
    if (method == Method::kTwoStepRelinearised) options.variant = TwoStepVariant::kRelinearised;
    TwoStepResult two_step = EstimateInTwoSteps(WithHeld(problem, joint), options);
    result.estimate = std::move(two_step.estimate);
    result.rate_measured = two_step.rate;
    if (method == Method::kTwoStep) result.rate_predicted = PredictedRate(problem, joint);
    if (method == Method::kTwoStep && IsUsable(result.estimate.status)) TakeNoise(problem, joint, &result.estimate);
  }
  if (IsUsable(result.estimate.status)) {
    result.estimate.identifiability.unidentifiable = joint.identifiability.unidentifiable;
  }
  result.max_deviation_sigma = LargestDeviation(result.estimate, joint);
  return result;
}

}  // namespace sagitta
