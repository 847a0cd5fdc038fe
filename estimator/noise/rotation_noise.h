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

// At a usable estimate; empty where noise is looked for otherwise, where no rotation was read, and where the residuals
// show none of either kind.
std::optional<TwoNoises> FindTwoNoises(const CalibrationProblem& problem, const Estimate& estimate);

// Where noise is stated and the residuals are several times as large (kInstrumentIsNotTheNoise), one factor on both
// kinds is that of neither: the robot, not the instrument, scatters, and what it does to points and to rotations nobody
// stated. With S_i stated, s the spread of the rotations' residuals and w the whitened one of the points, a rotation
// gets
//
//   root of (S_i S_i' + s^2 I) / w^2:
//
// points stay the unit of chi-square, rotations scatter as much in theirs.
struct RotationScatter {
  double spread = 0.0;  // s, rad
  NoiseRoots roots;     // of all observations of the data; of points those of `problem`
};
std::optional<RotationScatter> FindRotationScatter(const CalibrationProblem& problem, const Estimate& estimate);

// The second of them in a report; null where the report has none.
const VarianceComponent* RotationComponent(const NoiseReport& report);

}  // namespace sagitta
