// What a diagnosis proposes to measure next, for people.
#pragma once

#include <string>

#include "estimator/evidence/next_poses.h"

namespace sagitta {

// Between which answers, what it is expected to decide, and how the file is used.
std::string NextInWords(const CalibrationProblem& problem, const NextPoses& next);

}  // namespace sagitta
