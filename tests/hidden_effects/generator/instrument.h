// What a polar instrument makes of a point: circles that are not centred, a distance that does not start at its axes,
// reflectors seen at an angle, a stand that settles. It stands at the origin of the measurement frame, z up.
#pragma once

#include <Eigen/Core>

namespace hidden {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Graduated circles whose centres are off the axes they turn about, in radii of the circle.
struct Instrument {
  Vector2d azimuth_centre = Vector2d::Zero(), elevation_centre = Vector2d::Zero();
  double too_far = 0.0;    // m
  double curvature = 0.0;  // 1/m, of the ray: an arc that is bent towards the ground
};

// The point that its readings say.
Vector3d Read(const Instrument& instrument, const Vector3d& point);

// A corner cube in a sphere, its axis fixed to the flange: its centre seems to lie off by offset times the square of
// the angle (rad) under which it is seen.
struct Reflector {
  Vector3d axis = Vector3d::UnitZ();  // flange frame
  double offset = 0.0;                // m
};

// axis: in the measurement frame.
Vector3d SeenAtAnAngle(double offset, const Vector3d& axis, const Vector3d& point);

// The stand comes to rest: heat flows off in proportion to what is left of it.
struct Settling {
  Vector3d move = Vector3d::Zero(), turn = Vector3d::Zero();  // m, rad, at the start
  double time_constant = 1.0;                                 // s
};

double LeftOf(const Settling& settling, double since_start);

}  // namespace hidden
