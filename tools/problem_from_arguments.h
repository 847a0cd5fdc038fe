// EXP of the command line (FORMATS section 7): an experiment file, or
// ROBOT.yaml MEAS.csv…, and the flags that replace what the files say.
#pragma once

#include <gflags/gflags_declare.h>

#include <string>
#include <vector>

#include "problems/calibration_problem.h"
#include "problems/io/measurement_file.h"

DECLARE_double(sigma_mm);

namespace sagitta {

struct InputFile {
  std::string path;
  std::string sha256;
};
InputFile DescribeInput(const std::string& path);

struct ExperimentInputs {
  Experiment experiment;
  Robot robot;
  Measurements data;
  std::vector<InputFile> files;
};

// Throws InputError.
ExperimentInputs ReadExperimentInputs(const std::vector<std::string>& arguments,
                                      const MeasurementReadOptions& options = {});
bool IsExperimentFile(const std::string& path);

// The flags that an estimating command takes beside its own.
std::vector<std::string> WithProblemFlags(std::vector<std::string> flags);

// Applies the flags. Throws InputError.
CalibrationProblem ProblemAsStated(const ExperimentInputs& inputs);
// The same, and refuses data in a wrong unit.
CalibrationProblem ProblemFromInputs(const ExperimentInputs& inputs);

}  // namespace sagitta
