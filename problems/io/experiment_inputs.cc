#include "problems/io/experiment_inputs.h"

#include <algorithm>

#include "problems/input_error.h"
#include "problems/io/diagnosis_prior.h"
#include "problems/io/experiment_file.h"
#include "problems/io/files.h"
#include "problems/io/robot_file.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// An experiment file stands alone, wherever it was put.
Experiment ExperimentOf(const std::vector<std::string>& paths) {
  const auto experiment_file = std::find_if(paths.begin(), paths.end(), IsExperimentFile);
  if (experiment_file != paths.end()) {
    if (paths.size() == 1) return ReadExperimentFile(*experiment_file);
    const std::string& other = experiment_file == paths.begin() ? paths[1] : paths[0];
    throw InputError(
        {*experiment_file, 0, "measurements"},
        "an experiment file names its own robot and measurements, '" + other + "' is one argument too many",
        "list it there under robot: or measurements:, and give the experiment alone");
  }
  if (paths.size() < 2) {
    throw InputError({paths[0], 0, ""}, "the measurements are missing",
                     "give ROBOT.yaml MEAS.csv…, or a file with schema: sagitta/experiment/1");
  }
  Experiment experiment;
  experiment.robot_file = paths[0];
  experiment.measurement_files.assign(paths.begin() + 1, paths.end());
  return experiment;
}

}  // namespace

InputFile DescribeInput(const std::string& path) { return {path, Sha256(ReadTextFile(path))}; }

bool IsExperimentFile(const std::string& path) {
  const std::string text = ReadTextFile(path);
  if (text.find("schema") == std::string::npos) return false;  // of long files of measurements no lines are made
  for (const std::string& line : SplitText(text, '\n')) {
    const size_t first = line.find_first_not_of(" \t{\"");
    if (first == std::string::npos || line[first] == '#') continue;
    if (line.find("schema") == std::string::npos) continue;
    return line.find("sagitta/experiment/") != std::string::npos;
  }
  return false;
}

ExperimentInputs ReadExperimentInputs(const std::vector<std::string>& paths, const MeasurementReadOptions& options) {
  const FileSession once;
  ExperimentInputs inputs;
  inputs.experiment = ExperimentOf(paths);
  const Experiment& experiment = inputs.experiment;
  inputs.prior = ReadDiagnosisPrior(experiment.file);
  inputs.robot = ReadRobotFile(experiment.robot_file);
  inputs.data = ReadMeasurementsFor(inputs.robot, experiment.measurement_files, options);
  if (!experiment.file.empty()) inputs.files.push_back(DescribeInput(experiment.file));
  inputs.files.push_back(DescribeInput(experiment.robot_file));
  for (const MeasurementFile& file : inputs.data.files) {
    inputs.files.push_back({file.path, file.sha256});
    ForgetText(file.path);
  }
  return inputs;
}

}  // namespace sagitta
