// What the rows show by themselves, before anything is fitted: coverage of the joints, variety of the flange's
// orientation, copies, loads without their unloaded counterpart, columns that are absent and what they would allow.
#pragma once

#include <vector>

#include "estimator/inspection/finding.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct MeasuredRange {
  int joint = -1;
  double least = 0.0, most = 0.0;  // rad or m, over the calibration configurations
  double share = 0.0;              // of the limits; 0 where the robot file has none
};
std::vector<MeasuredRange> MeasuredRangesOf(const CalibrationProblem& problem);

// Those that cover less than 1 deg or 1 mm: what the joint does was not measured.
std::vector<MeasuredRange> StillJointsOf(const CalibrationProblem& problem);

std::vector<Finding> LintData(const CalibrationProblem& problem);

}  // namespace sagitta
