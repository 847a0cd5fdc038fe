#include "estimator/intervals/intervals.h"

#include "estimator/intervals/bootstrap.h"
#include "estimator/intervals/profile.h"
#include "problems/input_error.h"

namespace sagitta {

void CheckIntervalsFit(const CalibrationProblem& problem, const std::string& method) {
  const std::string& covariance = problem.experiment.covariance;
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
    ProfileIntervals(problem, {options.num_threads}, estimate);
  }
}

}  // namespace sagitta
