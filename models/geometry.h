// Rotations and rigid poses, templated on the scalar (double or ceres::Jet).
//
// Frames are always in names: `b_from_a` maps coordinates in frame a to
// coordinates in frame b; `point_in_base` is a point expressed in `base`.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace sagitta {

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

enum class Axis { kX = 0, kY = 1, kZ = 2 };

// [v]x with Skew(v) * w = v x w.
template <typename T>
Matrix3<T> Skew(const Vector3<T>& v) {
  Matrix3<T> skew;
  // clang-format off
  skew << T(0), -v.z(),  v.y(),
        v.z(),   T(0), -v.x(),
       -v.y(),  v.x(),   T(0);
  // clang-format on
  return skew;
}

// exp([v]x) as a quaternion (x, y, z, w); exact derivative at v = 0 for Jets.
template <typename T>
Eigen::Quaternion<T> QuaternionFromRotationVector(const Vector3<T>& v) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T squared_angle = v.squaredNorm();
  if (squared_angle > T(1e-24)) {
    const T angle = sqrt(squared_angle);
    const T k = sin(T(0.5) * angle) / angle;
    return {cos(T(0.5) * angle), k * v.x(), k * v.y(), k * v.z()};
  }
  // Series to first order: cos ~ 1 - |v|^2/8, sin(|v|/2)/|v| ~ 1/2.
  return {T(1) - squared_angle / T(8), T(0.5) * v.x(), T(0.5) * v.y(), T(0.5) * v.z()};
}

// R = exp([v]x), v in rad.
template <typename T>
Matrix3<T> RotationFromVector(const Vector3<T>& v) {
  return QuaternionFromRotationVector(v).toRotationMatrix();
}

// The inverse of QuaternionFromRotationVector, angle in [0, pi].
Vector3<double> RotationVector(const Eigen::Quaterniond& rotation);

// v with R = exp([v]x), rad.
Vector3<double> RotationVector(const Matrix3<double>& rotation);

// J of exp(v + dv) = exp(J dv) exp(v): what a change of the vector is as a left perturbation (Barfoot, State
// Estimation for Robotics, eq. 7.77).
Matrix3<double> LeftJacobian(const Vector3<double>& v);

// Its inverse, what a left perturbation is as a change of the vector.
Matrix3<double> InverseLeftJacobian(const Vector3<double>& v);

// Fixed-axis x-y-z angles as in URDF: R = Rz(yaw) Ry(pitch) Rx(roll).
Matrix3<double> RotationFromRpy(const Vector3<double>& rpy);

// Its inverse to 1e-15 at every pitch; yaw is 0 where roll and yaw turn about the same axis.
Vector3<double> RpyFromRotation(const Matrix3<double>& rotation);

// The least rotation that turns one direction into another.
Matrix3<double> RotationBetween(const Vector3<double>& from, const Vector3<double>& to);

// A rigid pose: p_target = rotation * p_source + translation.
template <typename T>
struct Pose {
  Matrix3<T> rotation = Matrix3<T>::Identity();
  Vector3<T> translation = Vector3<T>::Zero();

  Vector3<T> operator*(const Vector3<T>& point) const { return rotation * point + translation; }
};

// source_from_target of a pose target_from_source.
Pose<double> Inverse(const Pose<double>& pose);

// c_from_b b_from_a.
Pose<double> Product(const Pose<double>& c_from_b, const Pose<double>& b_from_a);

// Unit vector of this height, the k-th on a spiral about z whose steps are the golden angle: with equal steps in height
// directions lie evenly (Gonzalez 2010, Math. Geosci. 42, 49).
Vector3<double> OnSpiral(int k, double z);

}  // namespace sagitta
