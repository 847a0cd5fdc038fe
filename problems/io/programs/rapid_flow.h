// Routines, branches and loops of RAPID, and what holds until it is set again.
#pragma once

#include "problems/io/programs/program_flow.h"
#include "problems/io/programs/program_text.h"

namespace sagitta {

enum RapidVariable { kGripped, kDisplacement, kAxisOffset, kConfJ, kConfL, kRapidArm };

// source: in capitals.
ProgramFlow FlowOfRapid(const ProgramCode& source);

}  // namespace sagitta
