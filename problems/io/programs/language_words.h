// Words of the controllers' languages: what stands where a routine could be called and calls none.
#pragma once

#include <string>

#include "problems/io/programs/robot_program.h"

namespace sagitta {

// name: as the controller compares it, in capitals but for URScript. Of FANUC the first words of a statement that has
// neither sign nor bracket: LOCK PREG, COL DETECT ON.
bool IsWordOfLanguage(ProgramDialect dialect, const std::string& name);

}  // namespace sagitta
