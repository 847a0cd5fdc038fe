#include "tests/hidden_effects/generator/instrument.h"

#include <Eigen/Geometry>
#include <cmath>

namespace hidden {
namespace {

// A pointer of length 1 that turns about the axis by `angle`; the circle's centre is elsewhere, and the graduation
// where the pointer ends is the angle seen from there.
double ReadCircle(const Vector2d& centre, double angle) {
  const Vector2d pointed_at = Vector2d(std::cos(angle), std::sin(angle)) - centre;
  return std::atan2(pointed_at.y(), pointed_at.x());
}

}  // namespace

Vector3d Read(const Instrument& instrument, const Vector3d& point) {
  const double level = std::hypot(point.x(), point.y());
  const double azimuth = ReadCircle(instrument.azimuth_centre, std::atan2(point.y(), point.x()));
  // The ray arrives along the tangent of its arc, not along the chord.
  const double over_chord = std::asin(0.5 * instrument.curvature * point.norm());
  const double elevation = ReadCircle(instrument.elevation_centre, std::atan2(point.z(), level) + over_chord);
  const double range = point.norm() + instrument.too_far;
  return range * Vector3d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                          std::sin(elevation));
}

Vector3d SeenAtAnAngle(double offset, const Vector3d& axis, const Vector3d& point) {
  const Vector3d back = -point;  // to the instrument
  const double angle = std::atan2(axis.cross(back).norm(), axis.dot(back));
  return point * (1.0 + offset * angle * angle / point.norm());
}

// dx/dt = -x / tau by the midpoint rule; 1e-6 of it is lost in a thousand steps per time constant.
double LeftOf(const Settling& settling, double since_start) {
  const int steps = 1 + static_cast<int>(1000.0 * since_start / settling.time_constant);
  const double step = since_start / steps / settling.time_constant;
  double left = 1.0;
  for (int i = 0; i < steps; ++i) left -= step * (left - 0.5 * step * left);
  return left;
}

}  // namespace hidden
