// sagitta simulate: measurements of a stated truth.
#include <gflags/gflags.h>

#include <algorithm>
#include <iostream>
#include <optional>

#include "estimator/sagitta.h"
#include "problems/interruption.h"
#include "problems/io/experiment_file.h"
#include "problems/io/measurement_writer.h"
#include "problems/io/output_files.h"
#include "problems/range.h"
#include "tools/commands.h"
#include "tools/progress.h"
#include "tools/report/command_words.h"

DEFINE_string(truth, "", "an estimate.json or an experiment file that states robot, stations and markers");

namespace sagitta {
namespace {

// truth: estimate.json or experiment; may be empty.
KnownRobot ReadTruth(const std::string& truth, const std::string& experiment_path, const ExperimentInputs& inputs) {
  KnownRobot known;
  if (truth.empty() || truth == experiment_path) {
    known = KnownFrom(experiment_path, inputs.robot, inputs.experiment);
  } else if (IsExperimentFile(truth)) {
    const Experiment experiment = ReadExperimentFile(truth);
    known = KnownFrom(truth, ReadRobotFile(experiment.robot_file), experiment);
  } else {
    known = ReadEstimateFile(truth);
  }
  if (known.robot.num_joints() != inputs.robot.num_joints()) {
    throw InputError({known.file, 0, "robot"}, "the truth has " + std::to_string(known.robot.num_joints()) +
                                                   " joints, the robot of the experiment " +
                                                   std::to_string(inputs.robot.num_joints()));
  }
  if (!inputs.experiment.file.empty()) {  // the rows' loads are those of EXP
    const std::optional<ConditionOrigins> origins = known.loading.origins;
    known.loading = inputs.experiment;
    known.loading.origins = origins;
  }
  return known;
}

std::optional<double> SigmaFromFlags() {
  if (!IsGiven("sigma_mm")) return std::nullopt;
  CheckIn(allowed::kSigmaOrZero, FLAGS_sigma_mm / 1e3, "--sigma_mm");
  return FLAGS_sigma_mm / 1e3;
}

bool Deviate(const std::vector<Joint>& joints, const RepeatabilitySpec& stated) {
  return std::any_of(joints.begin(), joints.end(), [&stated](const Joint& joint) {
    return stated.Of(joint.type).StatedFor(joint.name).value_or(0.0) > 0.0;
  });
}

// Nothing states a standard deviation: the rows are exact.
bool IsExact(const ExperimentInputs& inputs, const std::optional<double>& sigma) {
  const Measurements& rows = inputs.data;
  const Experiment& experiment = inputs.experiment;
  if (Deviate(inputs.robot.chain.joints, experiment.repeatability)) return false;
  if (sigma) return *sigma == 0.0;
  for (const Observation& row : rows.observations) {
    if (IsStated(StatedRoot(experiment, rows, row, Vector3<double>::Ones()))) return false;
  }
  return true;
}

int RunSimulate(const CommandLine& line) {
  ExpectArguments(line, SimulateCommand(), 1, 1000);
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=FILE.csv");
  const OutputFile out(FLAGS_out);
  std::optional<Progress> progress;  // shares as measured on 390000 rows of the KR 270
  progress.emplace(FLAGS_quiet, std::vector<ProgressPhase>{{"reading", 1.0}, {"simulating", 1.0}, {"writing", 1.0}});
  progress->Say("reading the rows");
  MeasurementReadOptions options;
  options.points_required = false;
  const ExperimentInputs inputs = ReadExperimentInputs(line.arguments, options);
  const std::optional<double> sigma = SigmaFromFlags();
  progress->Say("simulating the readings");
  const Measurements simulated =
      Simulate(ReadTruth(FLAGS_truth, line.arguments[0], inputs), inputs.data, inputs.experiment, {sigma, FLAGS_seed});
  progress->Say("writing the rows");
  const std::string csv = MeasurementsToCsv(simulated);
  CheckInterruption();
  out.Write(csv);
  progress.reset();
  std::cout << SimulatedInWords(simulated.NumRows(), FLAGS_seed, IsExact(inputs, sigma), FLAGS_out);
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
(an instrument's range and angles too); rotations of poses have the noise of their rows, and of markers with a
rotvec_mrad every row is a pose; a stated repeatability moves each joint once per arrival.
The same seed gives the same numbers on every machine.

Examples
  sagitta simulate robot.yaml poses.csv --truth=results/estimate.json --sigma_mm=0.05 --out=simulated.csv
  sagitta simulate experiment.yaml --out=simulated.csv --seed=7
)",
          {"truth", "sigma_mm", "out", "seed", "threads", "quiet"},
          RunSimulate};
}

}  // namespace sagitta
