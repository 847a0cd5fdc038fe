// Where the stated sigmas are an instrument's and the robot scatters by far more, weights 1 / sigma^2 count what hardly
// matters: rows that the instrument saw a little better outvote the others. In addition to its stated covariance S_i
// every point then scatters by tau on each axis, found from the residuals r_i by maximum likelihood,
//
//   max over tau of  - sum_i ( ln det(S_i + tau^2 I) + r_i' (S_i + tau^2 I)^-1 r_i )
//
// and is weighed by both. Scaled to the mean of the stated variances: what is stated stays the unit of chi-square.
#pragma once

#include <string>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Reduced chi-square from which the instrument's stated noise is not what is left.
constexpr double kInstrumentIsNotTheNoise = 10.0;

// The robot is the noise: nothing else says how to weigh, the stated sigmas leave less than a quarter of the
// coordinates with a say, and the residuals of the judged estimate are several times as large.
bool ScattersByRobot(const CalibrationProblem& problem, const Estimate& estimate);

struct RobotScatter {
  double tau = 0.0;  // m, per coordinate
  NoiseRoots roots;  // of all observations of the data, m; rotations as stated
};
RobotScatter FindRobotScatter(const CalibrationProblem& problem, const Estimate& estimate);

// What one more measurement of a point shows in addition to its stated S_i, m per coordinate: tau as above, of as many
// residuals as the fit leaves free. One factor on all sigmas would widen rows that the instrument saw badly and leave
// rows that it saw well at a fraction of what the robot does there. 0: the residuals are not several times as large, or
// the noise is not stated for points alone.
double ScatterBeyondStated(const CalibrationProblem& problem, const Estimate& estimate);

}  // namespace sagitta
