#include "estimator/least_squares/rotation_manifold.h"

#include <utility>

#include "models/geometry.h"

namespace sagitta {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

Eigen::Matrix<double, 4, 3> QuaternionPlusJacobian(const double* x) {
  const Eigen::Map<const Eigen::Quaterniond> q(x);
  Eigen::Matrix<double, 4, 3> jacobian;
  // (d, 0) * (v, w) = (w d + d x v, -d . v)
  jacobian.topRows<3>() = 0.5 * (q.w() * Matrix3<double>::Identity() - Skew<double>(q.vec()));
  jacobian.row(3) = -0.5 * q.vec().transpose();
  return jacobian;
}

RotationManifold::RotationManifold(std::vector<int> free_axes) : free_axes_(std::move(free_axes)) {}

bool RotationManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  Vector3<double> v = Vector3<double>::Zero();
  for (size_t i = 0; i < free_axes_.size(); ++i) v[free_axes_[i]] = delta[i];
  const Eigen::Map<const Eigen::Quaterniond> q(x);
  Eigen::Map<Eigen::Quaterniond> result(x_plus_delta);
  result = QuaternionFromRotationVector(v) * Eigen::Quaterniond(q);
  return true;
}

bool RotationManifold::PlusJacobian(const double* x, double* jacobian) const {
  const Eigen::Matrix<double, 4, 3> full = QuaternionPlusJacobian(x);
  Eigen::Map<RowMajorMatrix> out(jacobian, 4, TangentSize());
  for (int i = 0; i < TangentSize(); ++i) out.col(i) = full.col(free_axes_[i]);
  return true;
}

bool RotationManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Eigen::Quaterniond difference =
      Eigen::Quaterniond(Eigen::Map<const Eigen::Quaterniond>(y)) * Eigen::Map<const Eigen::Quaterniond>(x).conjugate();
  const Vector3<double> v = RotationVector(difference);
  for (int i = 0; i < TangentSize(); ++i) y_minus_x[i] = v[free_axes_[i]];
  return true;
}

bool RotationManifold::MinusJacobian(const double* x, double* jacobian) const {
  // The columns of PlusJacobian are orthogonal with norm 1/2, so that the
  // pseudo-inverse is four times the transpose.
  Eigen::Map<RowMajorMatrix> out(jacobian, TangentSize(), 4);
  const Eigen::Matrix<double, 4, 3> full = QuaternionPlusJacobian(x);
  for (int i = 0; i < TangentSize(); ++i) out.row(i) = 4.0 * full.col(free_axes_[i]).transpose();
  return true;
}

}  // namespace sagitta
