#include "estimator/results/flange_side.h"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "models/kinematics.h"

namespace sagitta {
namespace {

constexpr double kParallel = 1e-3;  // rad, between two axes: what tables are rounded to is less
constexpr double kApart = 1e-3;     // m, of a flange from the wrist: less is no side
constexpr double kAlong = 0.99;     // cosine, of z and the axis: a flange at an angle faces no side

struct Axle {
  Vector3<double> point, direction;  // in the base, all joints at zero
};

Axle AxleOf(const Chain& chain, const std::vector<Pose<double>>& frames, int joint) {
  const int transform = chain.JointTransform(joint);
  const Pose<double>& frame = frames[static_cast<size_t>(transform)];
  return {frame.translation, frame.rotation.col(static_cast<int>(chain.transforms[transform].axis))};
}

// Where the last axis is nearest to the one before, p_n + t z_n:  t = (z_n - (z_n . z_b) z_b) . (p_b - p_n) / |z_n x
// z_b|^2
Vector3<double> NearestOnLast(const Axle& last, const Axle& before) {
  const double sine = last.direction.cross(before.direction).norm();
  const Vector3<double> across = last.direction - last.direction.dot(before.direction) * before.direction;
  return last.point + across.dot(before.point - last.point) / (sine * sine) * last.direction;
}

}  // namespace

bool FacesTheArm(const Chain& chain, const Pose<double>& controller_flange) {
  const int joints = chain.num_joints();
  const auto turns = [&chain](int joint) {
    return chain.joints[static_cast<size_t>(joint)].type == JointType::kRevolute;
  };
  if (joints < 2 || !turns(joints - 1) || !turns(joints - 2)) return false;
  const std::vector<Pose<double>> frames = NominalFrames(chain, Eigen::VectorXd::Zero(joints));
  const Axle last = AxleOf(chain, frames, joints - 1), before = AxleOf(chain, frames, joints - 2);
  if (last.direction.cross(before.direction).norm() < kParallel) return false;
  const Pose<double> flange = Product(frames.back(), controller_flange);
  const double out = last.direction.dot(flange.translation - NearestOnLast(last, before));
  const double along = last.direction.dot(flange.rotation.col(2));
  return std::abs(out) > kApart && std::abs(along) > kAlong && out * along < 0.0;
}

}  // namespace sagitta
