// Routines of KRL that are handed a variable.
#pragma once

#include <optional>
#include <string>

#include "problems/io/programs/program_text.h"

namespace sagitta {

// Where in the code, which is in capitals, a call first hands it to a routine, all of it or a part; system functions
// that only compute with it are none. `by_value`: a routine of the file that has it as :IN counts as well.
std::optional<size_t> HandedToRoutine(const std::string& code, const std::string& name, bool by_value);

}  // namespace sagitta
