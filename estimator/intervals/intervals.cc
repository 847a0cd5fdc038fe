#include "estimator/intervals/intervals.h"

#include "estimator/intervals/bootstrap.h"
#include "estimator/intervals/profile.h"
#include "estimator/noise/weighting.h"
#include "problems/input_error.h"

namespace sagitta {

void CheckIntervalsFit(const CalibrationProblem& problem, const std::string& method) {
  const Experiment& experiment = problem.experiment;
  const std::string& covariance = experiment.covariance;
  const bool needs_noise =
      covariance == "profile" || (covariance == "bootstrap" && experiment.bootstrap.kind != "configurations");
  if (WeighsByEq14(experiment) && needs_noise) {
    throw InputError({experiment.file, 0, "covariance"},
                     covariance + " needs the distribution of the noise, and the weights of eq. (14) are none",
                     "use covariance: model or sandwich, or bootstrap: {kind: configurations}");
  }
  if (method == "joint" || covariance == "model" || covariance == "sandwich") return;
  throw InputError({problem.experiment.file, 0, "covariance"},
                   covariance + " refits the joint estimate; it does not judge the method " + method,
                   "use --method=joint, or covariance: model");
}

void AddIntervals(const CalibrationProblem& problem, const IntervalOptions& options, Estimate* estimate) {
  const std::string& covariance = problem.experiment.covariance;
  if (covariance == "bootstrap") {
    BootstrapOptions bootstrap;
    bootstrap.kind = problem.experiment.bootstrap.kind;
    bootstrap.replicates = problem.experiment.bootstrap.replicates;
    bootstrap.seed = problem.experiment.bootstrap.seed;
    bootstrap.num_threads = options.num_threads;
    bootstrap.progress = options.progress;
    BootstrapIntervals(problem, bootstrap, estimate);
  } else if (covariance == "profile") {
    if (options.progress) options.progress("profile likelihood");
    ProfileOptions profile;
    profile.num_threads = options.num_threads;
    ProfileIntervals(problem, profile, estimate);
  }
}

}  // namespace sagitta
