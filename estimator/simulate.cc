#include "estimator/calibration/load_remedy.h"
#include "estimator/sagitta.h"
#include "problems/failure.h"
#include "problems/latent_model.h"
#include "problems/problem_checks.h"

namespace sagitta {
namespace {

// Root of every row's covariance where it is seen at `points`.
NoiseRoots RootsOf(const Experiment& experiment, const Measurements& rows, const Eigen::Matrix3Xd& points,
                   const std::optional<double>& sigma) {
  NoiseRoots roots;
  for (size_t i = 0; i < rows.observations.size(); ++i) {
    if (sigma && !rows.observations[i].is_point()) {  // its own, else exact
      roots.push_back(rows.observations[i].rotation_sigma.asDiagonal());
      continue;
    }
    roots.push_back(sigma ? Matrix3<double>(*sigma * Matrix3<double>::Identity())
                          : StatedRoot(experiment, rows, rows.observations[i], points.col(i)));
  }
  return roots;
}

}  // namespace

Measurements Simulate(const KnownRobot& known, const Measurements& given, const Experiment& experiment,
                      const SimulateOptions& options) {
  Measurements rows = given;
  AddKnownRotations(known, &rows);
  CalibrationProblem problem = PredictionProblem(known, rows);
  CheckLevelled(problem);
  problem.latent = MakeLatentModel(problem.robot.chain, problem.data, experiment);
  std::vector<int> all;
  for (size_t i = 0; i < rows.observations.size(); ++i) all.push_back(static_cast<int>(i));
  const Eigen::Matrix3Xd points = PredictPoints(problem, problem.parameters, all);
  if (!points.allFinite()) {
    throw Failure("nothing simulated: equilibrium_diverged: " + FoldedInWords(problem, problem.parameters));
  }
  const Simulator simulator(problem, problem.parameters, RootsOf(experiment, rows, points, options.sigma));
  Measurements simulated = problem.data;
  if (!simulator.Draw(options.seed, &simulated)) {
    throw Failure("nothing simulated: equilibrium_diverged: a joint's deviation folds the loaded arm");
  }
  return simulated;
}

}  // namespace sagitta
