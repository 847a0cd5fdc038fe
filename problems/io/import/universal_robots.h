// Writing for Universal Robots' controllers and drivers.
#pragma once

#include <string>

#include "models/kinematics.h"
#include "models/robot.h"

namespace sagitta {

// ROS' calibration.yaml (kinematics_params_file of the driver). Throws InputError for
// anything but six revolute joints whose flange lies on the last axis.
std::string RobotToUrCalibration(const Robot& robot);

}  // namespace sagitta
