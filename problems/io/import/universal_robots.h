// Writing for Universal Robots' controllers and drivers.
#pragma once

#include <string>

#include "models/kinematics.h"
#include "models/robot.h"

namespace sagitta {

// ROS' calibration.yaml (kinematics_params_file of the driver). Throws InputError for
// anything but six revolute joints whose flange lies on the last axis. hash: of the arm's own calibration, which
// ur_description reads and the driver compares; "": none is written.
std::string RobotToUrCalibration(const Robot& robot, const std::string& hash = "");
// kinematics: hash of a calibration.yaml; "": it has none, or the text is another file.
std::string HashOfUrCalibration(const std::string& text, const std::string& path);

// The controller's calibration.conf: delta_theta, delta_a, delta_d, delta_alpha of the exact standard table without
// beta (d runs along nearly parallel axes as the manufacturer's own calibrations do) from `nominal`. `kept`: a
// calibration.conf of the same arm, whose other lines stay byte for byte; "": the four lists alone. Throws InputError
// where the robot has no such table or `kept` lacks a list.
std::string RobotToUrConf(const Robot& robot, const DhTable& nominal, const std::string& kept,
                          const std::string& kept_path);

}  // namespace sagitta
