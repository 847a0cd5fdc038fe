// Routines, branches and loops of RAPID, and what holds until it is set again.
#pragma once

#include <string>

#include "problems/io/programs/program_flow.h"

namespace sagitta {

enum RapidVariable { kGripped, kDisplacement, kAxisOffset, kConfJ, kConfL, kRapidArm };

// code: without comments, in capital letters.
ProgramFlow FlowOfRapid(const std::string& code);

}  // namespace sagitta
