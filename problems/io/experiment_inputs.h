// EXP of FORMATS section 7: an experiment file, or ROBOT.yaml MEAS.csv….
#pragma once

#include <string>
#include <vector>

#include "models/robot.h"
#include "problems/experiment.h"
#include "problems/io/input_file.h"
#include "problems/io/measurement_file.h"
#include "problems/measurements.h"
#include "problems/prior_masses.h"

namespace sagitta {

// What the files say, before anything is put together.
struct ExperimentInputs {
  Experiment experiment;
  Robot robot;
  Measurements data;
  std::vector<InputFile> files;
  PriorMasses prior;  // of a diagnosis
};

// Throws InputError.
ExperimentInputs ReadExperimentInputs(const std::vector<std::string>& paths,
                                      const MeasurementReadOptions& options = {});

// Whether it is YAML with the schema of an experiment.
bool IsExperimentFile(const std::string& path);

// Path and SHA-256 of a file. Throws InputError where it cannot be read.
InputFile DescribeInput(const std::string& path);

}  // namespace sagitta
