#include "estimator/intervals/intervals.h"

#include "estimator/intervals/bootstrap.h"
#include "estimator/intervals/profile.h"
#include "estimator/noise/weighting.h"
#include "problems/input_error.h"
#include "problems/range.h"

namespace sagitta {

namespace {

void CheckIntervalsFit(const CalibrationProblem& problem, Method method) {
  const Experiment& experiment = problem.experiment();
  const CovarianceKind covariance = experiment.method.covariance;
  const bool needs_noise =
      covariance == CovarianceKind::kProfile ||
      (covariance == CovarianceKind::kBootstrap && experiment.method.bootstrap.kind != BootstrapKind::kConfigurations);
  if (WeighsByEq14(experiment) && needs_noise) {
    throw InputError({experiment.file, 0, "covariance"},
                     WordOf(covariance) + " needs the distribution of the noise, and the weights of eq. (14) are none",
                     "use covariance: model or sandwich, or bootstrap: {kind: configurations}");
  }
  const bool is_refitted = covariance == CovarianceKind::kBootstrap || covariance == CovarianceKind::kProfile;
  if (method == Method::kJoint || !is_refitted) return;
  throw InputError({problem.experiment().file, 0, "covariance"},
                   WordOf(covariance) + " refits the joint estimate; it does not judge the method " + WordOf(method),
                   "use --method=joint, or covariance: model");
}

}  // namespace

void CheckMethod(const CalibrationProblem& problem, Method method) {
  const std::string obstacle = MethodObstacle(problem, method);
  if (!obstacle.empty()) throw InputError({"", 0, "--method"}, obstacle, "use --method=joint, or state sigma_mm alone");
  CheckIntervalsFit(problem, method);
}

void CheckOptions(const IntervalOptions& options) {
  CheckIn(allowed::kThreads, options.num_threads, "IntervalOptions.num_threads");
}

void AddIntervals(const CalibrationProblem& problem, const IntervalOptions& options, Estimate* estimate) {
  CheckOptions(options);
  const CovarianceKind covariance = problem.experiment().method.covariance;
  if (covariance == CovarianceKind::kBootstrap) {
    BootstrapOptions bootstrap;
    bootstrap.kind = problem.experiment().method.bootstrap.kind;
    bootstrap.replicates = problem.experiment().method.bootstrap.replicates;
    bootstrap.seed = problem.experiment().method.bootstrap.seed;
    bootstrap.num_threads = options.num_threads;
    bootstrap.progress = options.progress;
    BootstrapIntervals(problem, bootstrap, estimate);
  } else if (covariance == CovarianceKind::kProfile) {
    if (options.progress) options.progress("profile likelihood");
    ProfileOptions profile;
    profile.num_threads = options.num_threads;
    ProfileIntervals(problem, profile, estimate);
  }
}

}  // namespace sagitta
