// Some hundred configurations show as well as all that a robot and its readings do not belong together, and trying some
// 150 other readings of 10^5 rows would need minutes.
#pragma once

#include "problems/calibration_problem.h"

namespace sagitta {

constexpr int kMostSampledConfigurations = 300;

// The fitted rows of at most 300 configurations, spread over the data; of more only where no fewer see every marker
// from every station. Nothing is held out. The whole problem where it has no more.
CalibrationProblem SampledProblem(const CalibrationProblem& problem);

}  // namespace sagitta
