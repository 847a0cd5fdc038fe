// The robot of a diagnosis as the next campaign finds it.
#pragma once

#include <optional>

#include "models/robot.h"

namespace sagitta {

// Effects that go with times count from the first row of the campaign they were found in, and another one begins anew:
// a joint that slipped has its zero where it went, all others are left out (a marker that was reseated is where the
// next campaign finds it, a station stands where it is put). None: no effect of the robot goes with times.
std::optional<Robot> RobotOfTheNextCampaign(const Robot& extended);

}  // namespace sagitta
