// Routines that a program calls and that are not in its file: what they set, and where they leave the arm, it cannot
// say.
#pragma once

#include "problems/io/programs/program_text.h"

namespace sagitta {

// Into program->calls_elsewhere. Instructions of the language count as no routines, and neither does a function whose
// value is used.
void FindCallsElsewhere(const ProgramCode& code, RobotProgram* program);

}  // namespace sagitta
