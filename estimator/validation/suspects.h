// Rows that cannot be what they say, each with what would make it fit: judged by the residual of a robust linear fit at
// the estimate (estimator/inspection/row_lint.h), so that the rows themselves do not hide it.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/row_stream.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct Suspect {
  int observation = -1;
  std::string row;  // "file:line"
  std::string words;
};

// Of the calibration rows, outliers that the noise model left out included. fitted: those rows where they are at hand.
std::vector<Suspect> FindSuspects(const CalibrationProblem& problem, const Estimate& estimate,
                                  const FittedStream* fitted = nullptr);

}  // namespace sagitta
