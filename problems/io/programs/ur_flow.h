// Routines, branches, loops and threads of URScript, and what holds until it is set again.
#pragma once

#include "problems/io/programs/program_flow.h"

namespace sagitta {

enum UrVariable { kUrTool, kUrLoad, kUrArm };

// code: without comments.
ProgramFlow FlowOfUrScript(const std::string& code);

}  // namespace sagitta
