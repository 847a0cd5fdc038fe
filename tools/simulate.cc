// sagitta simulate: measurements of a stated truth.
#include <gflags/gflags.h>

#include <filesystem>
#include <iostream>
#include <numeric>
#include <stdexcept>

#include "estimator/calibration/load_remedy.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/results/estimate_json.h"
#include "problems/input_error.h"
#include "problems/io/experiment_file.h"
#include "problems/io/files.h"
#include "problems/io/measurement_writer.h"
#include "problems/io/robot_file.h"
#include "problems/problem_checks.h"
#include "problems/simulation.h"
#include "tools/commands.h"
#include "tools/problem_from_arguments.h"

DEFINE_string(truth, "", "an estimate.json or an experiment file that states robot, stations and markers");

namespace sagitta {
namespace {

// The robot, `stations` and `markers` of an experiment.
KnownRobot KnownFromExperiment(const std::string& file, const Robot& robot, const Experiment& experiment) {
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
  return known;
}

void CheckHasScene(const KnownRobot& known) {
  const char* kHint =
      "state stations: {S1: {xyz_mm: …, rotvec_mrad: …}} and markers: {M1: {xyz_mm: …}} in an experiment "
      "file, or give --truth=ESTIMATE.json";
  if (known.base_in_station.empty())
    throw InputError({known.file, 0, "stations"}, "the truth states no base pose", kHint);
  if (known.markers.empty()) throw InputError({known.file, 0, "markers"}, "the truth states no marker point", kHint);
}

KnownRobot ReadTruth(const std::string& experiment_path, const ExperimentInputs& inputs) {
  KnownRobot known;
  if (FLAGS_truth.empty() || FLAGS_truth == experiment_path) {
    known = KnownFromExperiment(experiment_path, inputs.robot, inputs.experiment);
  } else if (IsExperimentFile(FLAGS_truth)) {
    const Experiment experiment = ReadExperimentFile(FLAGS_truth);
    known = KnownFromExperiment(FLAGS_truth, ReadRobotFile(experiment.robot_file), experiment);
  } else {
    known = ReadEstimateFile(FLAGS_truth);
  }
  if (known.robot.num_joints() != inputs.robot.num_joints()) {
    throw InputError({known.file, 0, "robot"}, "the truth has " + std::to_string(known.robot.num_joints()) +
                                                   " joints, the robot of the experiment " +
                                                   std::to_string(inputs.robot.num_joints()));
  }
  CheckHasScene(known);
  if (!inputs.experiment.file.empty()) {  // the rows' loads are those of EXP
    const std::optional<ConditionOrigins> origins = known.loading.origins;
    known.loading = inputs.experiment;
    known.loading.origins = origins;
  }
  return known;
}

// Root of every row's covariance where it is seen at `points`.
NoiseRoots NoiseOf(const ExperimentInputs& inputs, const Measurements& data, const Eigen::Matrix3Xd& points) {
  if (IsGiven("sigma_mm")) {
    if (!(FLAGS_sigma_mm >= 0.0)) throw InputError({"", 0, "--sigma_mm"}, "a standard deviation cannot be below 0");
    return NoiseRoots(data.observations.size(), FLAGS_sigma_mm / 1e3 * Matrix3<double>::Identity());
  }
  NoiseRoots roots;
  for (size_t i = 0; i < data.observations.size(); ++i) {
    roots.push_back(StatedRoot(inputs.experiment, data, data.observations[i], points.col(i)));
  }
  return roots;
}

std::vector<int> AllRows(const CalibrationProblem& problem) {
  std::vector<int> all(problem.data.observations.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// What a stated repeatability adds: one deviation of each joint per visit, to first order (1e-9 m for 30 urad). Drawn
// from a stream of its own, so that the instrument's noise is the same with and without.
Eigen::Matrix3Xd JointDeviations(CalibrationProblem problem, const Experiment& experiment) {
  const std::vector<int> all = AllRows(problem);
  Eigen::Matrix3Xd moved = Eigen::Matrix3Xd::Zero(3, all.size());
  problem.latent = MakeLatentModel(problem.robot.chain, problem.data, experiment);
  if (problem.latent.empty()) return moved;
  NormalNumbers normal(FLAGS_seed + 0x9e3779b97f4a7c15ULL);
  Eigen::MatrixXd deviations(problem.latent.size(), problem.latent.num_visits);
  for (double& deviation : deviations.reshaped()) deviation = normal();
  const NoiseRoots metres(all.size(), Matrix3<double>::Identity());
  const Linearization raw = Linearize(problem, problem.parameters, all, {}, metres, LatentTreatment::kIgnore);
  for (size_t i = 0; i < all.size(); ++i) {
    const int visit = problem.latent.visit_of_shot[problem.data.observations[i].shot];
    moved.col(i) = raw.latent.middleRows<3>(3 * static_cast<Eigen::Index>(i)) * deviations.col(visit);
  }
  return moved;
}

// As SimulateMeasurements, which knows no loads: n standard normal numbers per axis, in row order.
Measurements Simulate(const CalibrationProblem& problem, const Eigen::Matrix3Xd& points, const NoiseRoots& roots) {
  Measurements simulated = problem.data;
  NormalNumbers normal(FLAGS_seed);
  for (size_t i = 0; i < roots.size(); ++i) {
    Vector3<double> n;
    for (int axis = 0; axis < 3; ++axis) n[axis] = normal();
    simulated.observations[i].point_in_station = points.col(i) + roots[i] * n;
  }
  return simulated;
}

int RunSimulate(const CommandLine& line) {
  ExpectArguments(line, SimulateCommand(), 1, 1000);
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=FILE.csv");
  MeasurementReadOptions options;
  options.points_required = false;
  const ExperimentInputs inputs = ReadExperimentInputs(line.arguments, options);
  const CalibrationProblem problem = PredictionProblem(ReadTruth(line.arguments[0], inputs), inputs.data);
  CheckLevelled(problem);

  Eigen::Matrix3Xd points = PredictPoints(problem, problem.parameters, AllRows(problem));
  if (!points.allFinite()) {
    throw std::runtime_error("nothing simulated: equilibrium_diverged: " + FoldedInWords(problem, problem.parameters));
  }
  points += JointDeviations(problem, inputs.experiment);
  const NoiseRoots roots = NoiseOf(inputs, problem.data, points);
  const std::string csv = MeasurementsToCsv(Simulate(problem, points, roots));
  const std::filesystem::path folder = std::filesystem::path(FLAGS_out).parent_path();
  if (!folder.empty()) PrepareOutputFolder(folder.string());
  WriteTextFile(FLAGS_out, csv);
  double largest = 0.0;
  for (const Matrix3<double>& root : roots) largest = std::max(largest, root.norm());
  std::cout << roots.size() << " rows simulated with seed " << FLAGS_seed
            << (largest > 0.0 ? "" : ", exact: nothing states a standard deviation") << ": " << FLAGS_out << "\n";
  return 0;
}

}  // namespace

Command SimulateCommand() {
  return {"simulate",
          "measurements from a stated truth, with noise",
          R"(sagitta simulate EXP --truth=ESTIMATE.json --out=FILE.csv [--sigma_mm=0.01] [--seed=1]

EXP is an experiment file, or ROBOT.yaml MEAS.csv…. Its rows say which configurations, markers and stations
are seen; x, y, z may be absent. The truth is an estimate.json, or an experiment with its robot, `stations`
and `markers` (without --truth: EXP itself). The noise is --sigma_mm, else what rows or experiment state
(an instrument's range and angles too); a stated repeatability moves each joint once per arrival.
The same seed gives the same numbers on every machine.

Examples
  sagitta simulate robot.yaml poses.csv --truth=results/estimate.json --sigma_mm=0.05 --out=simulated.csv
  sagitta simulate experiment.yaml --out=simulated.csv --seed=7
)",
          {"truth", "sigma_mm", "out", "seed", "threads", "quiet"},
          RunSimulate};
}

}  // namespace sagitta
