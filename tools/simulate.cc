// sagitta simulate: measurements of a stated truth.
#include <gflags/gflags.h>

#include <filesystem>
#include <iostream>
#include <numeric>
#include <stdexcept>

#include "estimator/linearization.h"
#include "problems/input_error.h"
#include "problems/io/experiment_file.h"
#include "problems/io/files.h"
#include "problems/io/measurement_writer.h"
#include "problems/io/robot_file.h"
#include "problems/simulation.h"
#include "tools/commands.h"
#include "tools/estimate_json.h"

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
  if (!inputs.experiment.file.empty()) known.loading = inputs.experiment;  // the rows' loads are those of EXP
  return known;
}

std::vector<Vector3<double>> NoiseOf(const ExperimentInputs& inputs, const Measurements& data) {
  if (IsGiven("sigma_mm")) {
    if (!(FLAGS_sigma_mm >= 0.0)) throw InputError({"", 0, "--sigma_mm"}, "a standard deviation cannot be below 0");
    return std::vector<Vector3<double>>(data.observations.size(), Vector3<double>::Constant(FLAGS_sigma_mm / 1e3));
  }
  return SigmaOfRows(data, Vector3<double>::Constant(inputs.experiment.noise.sigma.value_or(0.0)));
}

// As SimulateMeasurements, which knows no loads: n standard normal numbers per axis, in row order.
Measurements Simulate(const CalibrationProblem& problem, const std::vector<Vector3<double>>& sigma) {
  Measurements simulated = problem.data;
  std::vector<int> all(simulated.observations.size());
  std::iota(all.begin(), all.end(), 0);
  const Eigen::Matrix3Xd points = PredictPoints(problem, problem.parameters, all);
  if (!points.allFinite()) throw std::runtime_error("the elastic equilibrium of a loaded row diverged");
  NormalNumbers normal(FLAGS_seed);
  for (size_t i = 0; i < all.size(); ++i) {
    simulated.observations[i].point_in_station = points.col(i);
    for (int axis = 0; axis < 3; ++axis) {
      simulated.observations[i].point_in_station[axis] += sigma[i][axis] * normal();
    }
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

  const std::vector<Vector3<double>> sigma = NoiseOf(inputs, problem.data);
  const std::string csv = MeasurementsToCsv(Simulate(problem, sigma));
  const std::filesystem::path folder = std::filesystem::path(FLAGS_out).parent_path();
  if (!folder.empty()) PrepareOutputFolder(folder.string());
  WriteTextFile(FLAGS_out, csv);
  double largest = 0.0;
  for (const Vector3<double>& s : sigma) largest = std::max(largest, s.maxCoeff());
  std::cout << sigma.size() << " rows simulated with seed " << FLAGS_seed
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
and `markers` (without --truth: EXP itself). The noise is --sigma_mm, else what rows or experiment state.
The same seed gives the same numbers on every machine.

Examples
  sagitta simulate robot.yaml poses.csv --truth=results/estimate.json --sigma_mm=0.05 --out=simulated.csv
  sagitta simulate experiment.yaml --out=simulated.csv --seed=7
)",
          {"truth", "sigma_mm", "out", "seed", "threads", "quiet"},
          RunSimulate};
}

}  // namespace sagitta
