// Routines that a program calls and that are not in its file: what they set, and where they leave the arm, it cannot
// say.
#pragma once

#include <regex>

#include "problems/io/programs/program_text.h"

namespace sagitta {

// How a dialect calls routines and begins those that are in the file.
struct CallPatterns {
  std::regex call;     // group 1: the name
  std::regex routine;  // group 1: the name
};
const CallPatterns& KrlCalls();
const CallPatterns& RapidCalls();
const CallPatterns& UrScriptCalls();
const CallPatterns& FanucCalls();

// Into program->calls_elsewhere. Instructions of the language count as no routines, and neither does a function whose
// value is used.
void FindCallsElsewhere(const ProgramCode& code, RobotProgram* program);

}  // namespace sagitta
