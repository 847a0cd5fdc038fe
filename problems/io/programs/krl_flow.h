// Routines, branches and loops of KRL, what holds until it is set again, and status and turn.
#pragma once

#include <optional>
#include <string>

#include "problems/io/programs/program_flow.h"
#include "problems/io/programs/program_text.h"

namespace sagitta {

enum KrlVariable { kKrlTool, kKrlBase, kKrlLoad, kKrlMode, kKrlArm };

// code: without comments, in capital letters.
ProgramFlow FlowOfKrl(const std::string& code);

// Status and turn as they are written: 2, 'B 010', 'H2'. Nothing: it is anything else.
std::optional<int> KrlBitsAt(const std::string& code, TextRange range);

}  // namespace sagitta
