#include "models/reading.h"

namespace sagitta {

Vector3<double> MeasuredMinusPredicted(const TargetReading& measured, const Vector3<double>& predicted) {
  if (measured.kind == ReadingKind::kPoint) return measured.point - predicted;
  return RotationVector(Matrix3<double>(measured.rotation * RotationFromVector(predicted).transpose()));
}

Matrix3<double> MisfitByPrediction(ReadingKind kind, const Vector3<double>& misfit) {
  return kind == ReadingKind::kPoint ? Matrix3<double>(Matrix3<double>::Identity()) : InverseLeftJacobian(misfit);
}

}  // namespace sagitta
