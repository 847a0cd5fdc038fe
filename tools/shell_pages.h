// Manual pages and shell completion, made of the command table when the program is built: what a command or a flag is
// called stands in one place.
#pragma once

#include <string>
#include <vector>

#include "tools/command_line.h"

namespace sagitta {

// Writes DIR/man/sagitta.1, DIR/man/sagitta-COMMAND.1, DIR/bash/sagitta and DIR/zsh/_sagitta.
void WriteShellPages(const std::vector<Command>& commands, const std::string& overview, const std::string& folder);

}  // namespace sagitta
