// Which load a program's points are corrected for, and why one is not known. Masses in kg, lengths come in m.
#pragma once

#include <string>

#include "problems/io/programs/robot_program.h"

namespace sagitta {

std::string LoadUsedInWords(const std::string& name, const ProgramLoad& load, int points);
std::string LoadUnknownInWords(const std::string& name, int points);
std::string LoadOfTwoInWords(const std::string& one, const std::string& other);
std::string ToolReplacedInWords(double tool_mass);

}  // namespace sagitta
