// Can geometric errors of a size that robots have explain what the nominal robot misses by? The most probable ones,
//
//   min  sum |predicted - measured|^2 / s^2  +  sum (error / size)^2
//
// over all geometric errors, base poses and markers, by damped Gauss-Newton from the aligned nominal robot. Errors of
// at most 5 mm and 1 deg that made the readings are one candidate of that minimum, so what it finds is no larger as a
// whole; a wrong sign, zero, convention or another arm needs far more, or leaves the misfit where it is.
#pragma once

#include <string>
#include <vector>

#include "models/constants.h"
#include "problems/calibration_problem.h"

namespace sagitta {

constexpr double kErrorLength = 5e-3;          // m, size of an error that robots have
constexpr double kErrorAngle = 1.0 * kDegree;  // rad

struct ExplainedErrors {
  double left = 0.0;    // distance RMS, m, that the errors leave
  std::string largest;  // the largest relative to its size: coordinate name
  double value = 0.0;   // of it, SI
  Quantity quantity = Quantity::kLength;
  double relative = 0.0;  // |value| over its size
};

ExplainedErrors ExplainByErrors(const CalibrationProblem& problem, const std::vector<int>& rows);

}  // namespace sagitta
