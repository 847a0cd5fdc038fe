#include "models/geometry.h"

#include "models/constants.h"

namespace sagitta {

Vector3<double> RotationVector(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1.0 : 1.0;
  const Vector3<double> v = sign * rotation.vec();
  const double n = v.norm();
  if (n < 1e-12) return 2.0 * v;
  return 2.0 * std::atan2(n, sign * rotation.w()) / n * v;
}

Vector3<double> RotationVector(const Matrix3<double>& rotation) { return RotationVector(Eigen::Quaterniond(rotation)); }

// J = I + (1 - cos a) / a^2 [v]x + (a - sin a) / a^3 [v]x^2, a = |v|; the coefficients are 1/2 and 1/6 to 1e-9 below
// 1e-4 rad.
Matrix3<double> LeftJacobian(const Vector3<double>& v) {
  const double angle = v.norm();
  const bool is_small = angle < 1e-4;
  const double a = is_small ? 0.5 : (1.0 - std::cos(angle)) / (angle * angle);
  const double b = is_small ? 1.0 / 6.0 : (angle - std::sin(angle)) / (angle * angle * angle);
  const Matrix3<double> skew = Skew(v);
  return Matrix3<double>::Identity() + a * skew + b * skew * skew;
}

// J^-1 = I - 1/2 [v]x + (1 - (a / 2) cot(a / 2)) / a^2 [v]x^2; 1/12 is the limit of the last coefficient.
Matrix3<double> InverseLeftJacobian(const Vector3<double>& v) {
  const double angle = v.norm();
  const double half = 0.5 * angle;
  const double b = angle < 1e-4 ? 1.0 / 12.0 : (1.0 - half * std::cos(half) / std::sin(half)) / (angle * angle);
  const Matrix3<double> skew = Skew(v);
  return Matrix3<double>::Identity() - 0.5 * skew + b * skew * skew;
}

Matrix3<double> RotationFromRpy(const Vector3<double>& rpy) {
  using Eigen::AngleAxisd;
  return (AngleAxisd(rpy.z(), Vector3<double>::UnitZ()) * AngleAxisd(rpy.y(), Vector3<double>::UnitY()) *
          AngleAxisd(rpy.x(), Vector3<double>::UnitX()))
      .toRotationMatrix();
}

Vector3<double> RpyFromRotation(const Matrix3<double>& rotation) {
  // Each angle is read from what the ones before leave, so that an undetermined yaw does no harm.
  const double yaw = std::atan2(rotation(1, 0), rotation(0, 0));
  const Matrix3<double> rest = Eigen::AngleAxisd(-yaw, Vector3<double>::UnitZ()).toRotationMatrix() * rotation;
  return {std::atan2(-rest(1, 2), rest(1, 1)), std::atan2(-rest(2, 0), rest(0, 0)), yaw};
}

// R = I + [v]x + [v]x^2 / (1 + a . b), v = a x b (Rodrigues with the sine in v).
Matrix3<double> RotationBetween(const Vector3<double>& from, const Vector3<double>& to) {
  const Vector3<double> a = from.normalized(), b = to.normalized();
  const double cosine = a.dot(b);
  // Opposite to rounding: half a turn about any axis across.
  if (1.0 + cosine < 1e-12) return RotationFromVector<double>(kPi * a.unitOrthogonal());
  const Matrix3<double> skew = Skew<double>(a.cross(b));
  return Matrix3<double>::Identity() + skew + skew * skew / (1.0 + cosine);
}

Pose<double> Inverse(const Pose<double>& pose) {
  const Matrix3<double> back = pose.rotation.transpose();
  return {back, -(back * pose.translation)};
}

Pose<double> Product(const Pose<double>& c_from_b, const Pose<double>& b_from_a) {
  return {c_from_b.rotation * b_from_a.rotation, c_from_b * b_from_a.translation};
}

Vector3<double> OnSpiral(int k, double z) {
  const double golden_angle = kPi * (3.0 - std::sqrt(5.0)), r = std::sqrt(1.0 - z * z);
  return {r * std::cos(golden_angle * k), r * std::sin(golden_angle * k), z};
}

}  // namespace sagitta
