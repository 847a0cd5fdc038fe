// Routines of RAPID that are called by a text that is their name.
#pragma once

#include <string>
#include <vector>

#include "problems/io/programs/program_flow.h"
#include "problems/io/programs/program_text.h"

namespace sagitta {

// %"grip"%; CallByVar "grip", 1; MoveLSync p1, v100, z10, gun, "grip";
struct RapidCallByName {
  size_t at = 0;
  std::string name;          // in capitals, without its module; "": it is computed
  bool any_number = false;   // the name goes on with a number that is computed
  bool at_any_time = false;  // on the way of a motion, while the program goes on
};

// The quoted text that is all of the code there, in capitals and without its module, "M:GRIP". "": there is more, or
// none.
std::string RapidNameAt(const ProgramCode& source, TextRange range);

// source: in capitals.
std::vector<RapidCallByName> RapidCallsByName(const ProgramCode& source);

// Whether it may be a call of the routine.
bool MayCall(const RapidCallByName& call, const std::string& routine);

// Into program->calls_elsewhere those that call no routine of this file, and those of which that is not known.
void FindRapidCallsElsewhere(const ProgramCode& source, RobotProgram* program);

}  // namespace sagitta
