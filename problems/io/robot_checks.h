// What every robot has to be, whatever file it was read from.
#pragma once

#include <string>

#include "models/robot.h"

namespace sagitta {

// Sizes and numbers within problems/limits.h, names without control characters. Throws InputError.
void CheckRobot(const Robot& robot, const std::string& file_in_messages);

// Well-formed XML of a size, depth and number of elements that its readers can be given. Throws InputError.
void CheckXml(const std::string& text, const std::string& file_in_messages);

}  // namespace sagitta
