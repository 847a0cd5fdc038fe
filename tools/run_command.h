// What the programs' main functions share: exit statuses, logging, errors in words.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/command_line.h"

namespace sagitta {

// FORMATS section 4.
constexpr int kRequirementNotMet = 1;
constexpr int kUsageError = 2;
constexpr int kNumericalFailure = 3;

// Runs `program` with logging set up; an InputError becomes words on stderr and exit status 2, any other
// exception 3. At Ctrl-C what iterates ends with an Interruption, which says so and ends the program as the signal
// would have. What the output streams show holds no control characters; a standard output that cannot be written is an
// error.
int RunGuarded(const char* program_path, const std::function<int()>& program);

// Parses the arguments and runs the command, or prints its help.
int RunCommand(const Command& command, const std::vector<std::string>& arguments);

std::string HelpOf(const Command& command);

// Replaces this process by a program of the same folder. Returns only on failure, with its exit status.
int HandOver(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace sagitta
