#pragma once

#include "problems/io/import/robot_reading.h"

namespace sagitta {

// --convention, --base_link, --tip_link, --nominal: how a foreign robot file is to be read.
RobotReadOptions RobotOptionsFromFlags();

}  // namespace sagitta
