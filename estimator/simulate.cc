#include "estimator/calibration/load_remedy.h"
#include "estimator/sagitta.h"
#include "problems/experiment_checks.h"
#include "problems/failure.h"
#include "problems/io/measurement_writer.h"
#include "problems/latent_model.h"
#include "problems/problem_checks.h"
#include "problems/range.h"
#include "problems/structure_checks.h"

namespace sagitta {
namespace {

// Root of every row's covariance where it is seen at `points`.
NoiseRoots RootsOf(const Experiment& experiment, const Measurements& rows, const Eigen::Matrix3Xd& points,
                   const std::optional<double>& sigma) {
  NoiseRoots roots;
  for (size_t i = 0; i < rows.observations.size(); ++i) {
    if (sigma && !rows.observations[i].is_point()) {  // its own, else exact
      roots.push_back(rows.observations[i].rotation().sigma.asDiagonal());
      continue;
    }
    roots.push_back(sigma ? Matrix3<double>(*sigma * Matrix3<double>::Identity())
                          : StatedRoot(experiment, rows, rows.observations[i], points.col(i)));
  }
  return roots;
}

void CheckHasScene(const KnownRobot& known) {
  const char* kHint =
      "state stations: {S1: {xyz_mm: …, rotvec_mrad: …}} and markers: {M1: {xyz_mm: …}} in an experiment "
      "file, or give --truth=ESTIMATE.json";
  if (known.base_in_station.empty())
    throw InputError({known.file, 0, "stations"}, "the truth states no base pose", kHint);
  if (known.markers.empty()) throw InputError({known.file, 0, "markers"}, "the truth states no marker point", kHint);
}

}  // namespace

KnownRobot KnownFrom(const std::string& file, const Robot& robot, const Experiment& experiment) {
  KnownRobot known;
  known.file = file;
  known.robot = robot;
  known.loading = experiment;
  for (const auto& [name, spec] : experiment.stations) {
    if (!spec.base_xyz && !spec.base_rotvec) continue;
    Pose<double> pose;
    pose.translation = spec.base_xyz.value_or(Vector3<double>::Zero());
    pose.rotation = RotationFromVector(spec.base_rotvec.value_or(Vector3<double>::Zero()));
    known.base_in_station[name] = pose;
  }
  for (const auto& [name, spec] : experiment.markers) {
    if (spec.point) known.markers[name] = spec;
  }
  CheckHasScene(known);
  return known;
}

void CheckOptions(const SimulateOptions& options) {
  if (options.sigma) CheckIn(allowed::kSigmaOrZero, *options.sigma, "SimulateOptions.sigma");
}

Measurements Simulate(const KnownRobot& known, const Measurements& given, const Experiment& experiment,
                      const SimulateOptions& options) {
  CheckOptions(options);
  CheckExperiment(experiment);
  CheckStructure(known.robot, given);
  Measurements rows = given;
  AddKnownRotations(known, &rows);
  CalibrationProblem problem = PredictionProblem(known, rows);
  CheckLevelled(problem);
  problem.latent = MakeLatentModel(problem.robot().chain, problem.data(), experiment);
  std::vector<int> all;
  for (size_t i = 0; i < rows.observations.size(); ++i) all.push_back(static_cast<int>(i));
  const Eigen::Matrix3Xd points = PredictPoints(problem, problem.parameters, all);
  if (!points.allFinite()) {
    throw Failure("nothing simulated: equilibrium_diverged: " + FoldedInWords(problem, problem.parameters));
  }
  const Simulator simulator(problem, problem.parameters, RootsOf(experiment, rows, points, options.sigma));
  Measurements simulated = problem.data();
  if (!simulator.Draw(options.seed, &simulated)) {
    throw Failure("nothing simulated: equilibrium_diverged: a joint's deviation folds the loaded arm");
  }
  if (options.sigma) StateSigma(*options.sigma, &simulated);
  return simulated;
}

}  // namespace sagitta
