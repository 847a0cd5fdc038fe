// The aligned nominal robot and its linearization, without the rows that are far off: what an inspection stands on.
#pragma once

#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/inspection/finding.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {

constexpr double kUnstatedSigma = 1e-3;  // m, where none is stated: its scale is estimated

struct LinearState {
  CalibrationProblem problem;  // without gross outliers
  ParameterSet parameters;     // aligned
  Linearization all;           // every requested coordinate
  Linearization estimated;     // what the data can determine of them
  double scale = 1.0;          // of the whitening sigmas
  Unidentifiable lost;
};

// Rows that are far off are named, left out, and the rest aligned again until the same rows are. `misfit`: the robot
// does not fit the rows at all; then no row is judged and the noise is as stated. Else the linearization is where one
// linear step puts base, markers and geometry.
LinearState Align(const CalibrationProblem& problem, bool misfit, std::vector<Finding>* findings);

}  // namespace sagitta
