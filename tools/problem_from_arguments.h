// The flags that replace what the files of EXP say (FORMATS section 3).
#pragma once

#include <gflags/gflags_declare.h>

#include <string>
#include <vector>

#include "problems/calibration_problem.h"
#include "problems/io/experiment_inputs.h"

DECLARE_double(sigma_mm);
DECLARE_string(load_point_mm);
DECLARE_bool(force);
DECLARE_string(method);

namespace sagitta {

// The flags that an estimating command accepts in addition to its own.
std::vector<std::string> WithProblemFlags(std::vector<std::string> flags);

// Of --load_point_mm, m. Throws InputError.
Vector3<double> LoadPointOfFlag(const std::string& x_y_z);

// EXP of a command with these flags: what a flag replaces is not checked in the rows. Throws InputError.
ExperimentInputs ReadInputs(const std::vector<std::string>& paths);
// Applies the flags. Throws InputError.
CalibrationProblem ProblemAsStated(ExperimentInputs inputs);
// The same, and refuses data in a wrong unit.
CalibrationProblem ProblemFromInputs(ExperimentInputs inputs);
// The same, and refuses readings that the nominal robot cannot have made. --force: as stated, whatever it is.
CalibrationProblem PlausibleProblem(ExperimentInputs inputs);

}  // namespace sagitta
