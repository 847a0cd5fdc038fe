// Whether readings of one shot err alike, as they do where the arm is off and not the instrument.
#pragma once

#include "estimator/agreement/part_fits.h"

namespace sagitta {

// Points of one shot that err alike, whitened and given the fit: with W_ik = 1 for two points of one shot and 0 else,
// M = 1 - J C J', n rows, nu = n - tr J C J' and s^2 = r'r / nu
//   Q = r'W r = sum over shots of |sum_i r_i|^2 - sum_i |r_i|^2,   E Q = s^2 tr MW,
//   Var Q = 2 s^4 (tr (MW)^2 - (tr MW)^2 / nu)   (s^2 is found from the same residuals)
// Returns (Q - E Q) / sqrt(Var Q), which is normal where rows are independent; 0 where rows are too many to be held
// (then the sandwich itself is well known) or no shot has two points.
double SharedErrors(const CalibrationProblem& problem, const Whole& whole);

}  // namespace sagitta
