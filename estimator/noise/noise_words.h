// What the noise is, in words: fills source and words of the NoiseReport, and the warnings of the estimate.
#pragma once

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

void DescribeNoise(const CalibrationProblem& problem, Estimate* estimate);

}  // namespace sagitta
