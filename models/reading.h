// What an instrument reads of a target, three numbers each, and how far a prediction is from it.
//
//   point      p, m                       predicted - measured = p_predicted - p_measured
//   rotation   R, of the target's frame   predicted - measured = log(R_predicted R_measured'), rad
//
// both in the measurement frame; the second is the left perturbation that turns the measured rotation into the
// predicted one. A pose is a point and a rotation of the same target: two readings, each with a covariance of its own.
// Whatever else an instrument reads is one more kind here.
#pragma once

#include "models/geometry.h"

namespace sagitta {

enum class ReadingKind { kPoint, kRotation };

// What was read of a target: its point, m, or its rotation, in the station frame.
struct TargetReading {
  ReadingKind kind = ReadingKind::kPoint;
  Vector3<double> point = Vector3<double>::Zero();         // m; of a rotation: where its target is
  Matrix3<double> rotation = Matrix3<double>::Identity();  // of kRotation: station_from_target
};

// measured - predicted. `predicted` is a point, or a rotation vector.
Vector3<double> MeasuredMinusPredicted(const TargetReading& measured, const Vector3<double>& predicted);

// d misfit / d prediction, the latter by left perturbation; misfit = predicted - measured.
Matrix3<double> MisfitByPrediction(ReadingKind kind, const Vector3<double>& misfit);

}  // namespace sagitta
