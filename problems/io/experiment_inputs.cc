#include "problems/io/experiment_inputs.h"

#include <algorithm>
#include <filesystem>

#include "problems/input_error.h"
#include "problems/io/diagnosis_prior.h"
#include "problems/io/experiment_file.h"
#include "problems/io/files.h"
#include "problems/io/robot_file.h"
#include "problems/io/text_checks.h"
#include "problems/text.h"

namespace sagitta {
namespace {

void CheckFilesExist(const Experiment& experiment) {
  const auto check = [&](const std::string& key, const std::string& path) {
    std::error_code error;
    if (std::filesystem::exists(path, error)) return;
    const auto line = experiment.lines.find(key);
    throw InputError({experiment.file, line == experiment.lines.end() ? 0 : line->second, key},
                     "there is no file '" + Printable(path) + "'", "paths are relative to the experiment file");
  };
  check("robot", experiment.robot_file);
  for (const std::string& path : experiment.measurement_files) check("measurements", path);
}

// One file that is no experiment: what is missing next to it.
[[noreturn]] void FailAlone(const std::string& path) {
  const std::string text = ReadTextFile(path);
  const std::string hint = "give ROBOT.yaml MEAS.csv…, or a file with schema: sagitta/experiment/1";
  const auto has_line = [&text](const std::string& beginning) {
    return text.compare(0, beginning.size(), beginning) == 0 || text.find("\n" + beginning) != std::string::npos;
  };
  if (has_line("measurements:") && has_line("schema:")) {
    const auto line = static_cast<int>(std::count(text.begin(), text.begin() + text.find("schema:"), '\n')) + 1;
    throw InputError({path, line, "schema"}, "this is another schema than that of an experiment",
                     "schema: sagitta/experiment/1");
  }
  if (has_line("measurements:"))
    throw InputError({path, 0, "schema"}, "this key is missing", "schema: sagitta/experiment/1");
  if (has_line("config,")) throw InputError({path, 0, ""}, "these are measurements, the robot is missing", hint);
  throw InputError({path, 0, ""}, "the measurements are missing", hint);
}

// An experiment file stands alone, wherever it was put.
Experiment ExperimentOf(const std::vector<std::string>& paths) {
  if (paths.empty()) {
    throw InputError({}, "no file is given", "give ROBOT.yaml MEAS.csv…, or a file with schema: sagitta/experiment/1");
  }
  const auto experiment_file = std::find_if(paths.begin(), paths.end(), IsExperimentFile);
  if (experiment_file != paths.end()) {
    if (paths.size() == 1) {
      Experiment experiment = ReadExperimentFile(*experiment_file);
      CheckFilesExist(experiment);
      return experiment;
    }
    const std::string& other = experiment_file == paths.begin() ? paths[1] : paths[0];
    throw InputError(
        {*experiment_file, 0, "measurements"},
        "an experiment file names its own robot and measurements, '" + other + "' is one argument too many",
        "list it there under robot: or measurements:, and give the experiment alone");
  }
  if (paths.size() < 2) FailAlone(paths[0]);
  Experiment experiment;
  experiment.robot_file = paths[0];
  experiment.measurement_files.assign(paths.begin() + 1, paths.end());
  return experiment;
}

}  // namespace

InputFile DescribeInput(const std::string& path) { return {path, Sha256(ReadTextFile(path))}; }

bool IsExperimentFile(const std::string& path) {
  const std::shared_ptr<const std::string> kept = SharedText(path);
  const std::string& text = *kept;
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
