// Sizes that machines show, with their sources: what the diagnosis expects of an effect is a thirtieth to three times
// as much.
#pragma once

#include <string>

namespace sagitta {

// How far an effect moves the points (RMS over coordinates, m) whose size depends on the robot (loads, weights,
// springs): what they leave after a calibration of the geometry, 0.05 to 0.6 mm (Nubiola and Bonev 2013; Klimchik et
// al. 2015).
constexpr double kTypicalDisplacement = 3e-4;

// SI. 0: depends on the size of the robot, what moves the points by kTypicalDisplacement.
double TypicalSize(const std::string& effect, const std::string& parameter);

}  // namespace sagitta
