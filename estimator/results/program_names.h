// Tools, frames and loads that the user states, by the names that the program has for them.
#pragma once

#include "estimator/results/program_compensation.h"

namespace sagitta {

// `stated` with every name as the file's reader has it: KRL, RAPID and FANUC LS ignore case. Throws InputError for a
// name that is nowhere in the program, and for one that is stated twice.
ProgramScene SceneByNames(const RobotProgram& program, const ProgramScene& stated);

}  // namespace sagitta
