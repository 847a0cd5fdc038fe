// What the noise is, in words: fills source and words of the NoiseReport, and the warnings of the estimate.
#pragma once

#include <string>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// tau: what every coordinate scatters by beside the stated sigmas, m (noise/robot_scatter.h).
std::string RobotScatterInWords(double tau);

void DescribeNoise(const CalibrationProblem& problem, Estimate* estimate);

}  // namespace sagitta
