// Where nothing states any noise, points and rotations of poses have no common unit: a tracker that reads a target to
// 0.05 mm may turn it by 0.1 or by 1 mrad. Each kind then gets the spread of its own residuals,
//
//   s_k^2 = sum r^2 / sum (1 - h),   k = points (m), rotations (rad),   h the leverage of a row at these weights,
//
// Helmert's variance components of two groups, whose fixed point is found by fitting again.
#pragma once

#include <optional>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct TwoNoises {
  std::vector<VarianceComponent> components;  // of points, m per coordinate, then of rotations, rad per axis
  NoiseRoots roots;                           // of all observations of the data
};

// At a usable estimate; empty where noise is stated or looked for otherwise, where no rotation was read, and where the
// residuals show none of either kind.
std::optional<TwoNoises> FindTwoNoises(const CalibrationProblem& problem, const Estimate& estimate);

// Where noise is stated and the residuals are several times as large (kInstrumentIsNotTheNoise), one factor on both
// kinds is that of neither: the robot, not the instrument, scatters, and what it does to points and to rotations nobody
// stated. Roots by which both kinds scatter alike: of points as they are, of rotations times (s_r / s_p) / (their
// stated ratio). Points stay the unit of chi-square.
struct RotationFactor {
  double factor = 1.0;  // on the roots that are stated
  NoiseRoots roots;     // of all observations of the data
};
std::optional<RotationFactor> FindRotationFactor(const CalibrationProblem& problem, const Estimate& estimate);

// The second of them in a report; null where the report has none.
const VarianceComponent* RotationComponent(const NoiseReport& report);

}  // namespace sagitta
