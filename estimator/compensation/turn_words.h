// What is said of a pose whose whole turns may be of several joints.
#pragma once

#include <string>

namespace sagitta {

std::string TurnsInWords();

}  // namespace sagitta
