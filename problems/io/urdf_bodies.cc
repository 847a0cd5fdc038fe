#include "problems/io/urdf_bodies.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "models/kinematics.h"
#include "problems/input_error.h"
#include "problems/io/urdf_robot.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Isometry = Eigen::Isometry3d;

constexpr double kElsewhere = 0.02;  // m and rad: beyond any calibration of a sound robot

Isometry AsIsometry(const Pose<double>& pose) {
  Isometry isometry = Isometry::Identity();
  isometry.linear() = pose.rotation;
  isometry.translation() = pose.translation;
  return isometry;
}

// base_from_frame right after every joint of the nominal chain.
std::vector<Isometry> FramesAt(const Chain& chain, const Eigen::VectorXd& q) {
  const std::vector<Pose<double>> nominal = NominalFrames(chain, q);
  std::vector<Isometry> frames;
  for (int j = 0; j < chain.num_joints(); ++j) frames.push_back(AsIsometry(nominal[chain.FrameAfterJoint(j)]));
  return frames;
}

// own_from_urdf of the frames after each joint: constant, where both chains are those of one arm.
std::vector<Isometry> Between(const Chain& own, const Chain& urdf, const std::string& file) {
  const int n = urdf.num_joints();
  std::vector<Isometry> between;
  for (int trial = 0; trial < 3; ++trial) {
    Eigen::VectorXd q(n);
    for (int j = 0; j < n; ++j) q[j] = 0.4 * trial * std::sin(1.0 + 2.0 * j);
    const std::vector<Isometry> here = FramesAt(own, q), there = FramesAt(urdf, q);
    for (int j = 0; j < n; ++j) {
      const Isometry motion = here[j].inverse() * there[j];
      if (trial == 0) {
        between.push_back(motion);
        continue;
      }
      const Isometry moved = between[j].inverse() * motion;
      if (moved.translation().norm() < kElsewhere && Eigen::AngleAxisd(moved.linear()).angle() < kElsewhere) continue;
      throw InputError({file, 0, urdf.joints[j].name}, "the robot's joint moves otherwise than that of the URDF",
                       "the URDF has to be of this robot, with the same base, zeros and signs");
    }
  }
  return between;
}

// frame_from_joint of the URDF: after an oblique axis the chain's frame right after the motion has z along it.
Isometry FrameFromJoint(const UrdfJoint& joint) {
  if (ElementaryAxis(joint.axis)) return Isometry::Identity();
  const double azimuth = std::atan2(joint.axis.y(), joint.axis.x());
  const double polar = std::atan2(joint.axis.head<2>().norm(), joint.axis.z());
  return Isometry(Eigen::AngleAxisd(-polar, Vector3<double>::UnitY()) *
                  Eigen::AngleAxisd(-azimuth, Vector3<double>::UnitZ()));
}

// Half the line of a capsule around the shape, in the shape's frame, and its radius.
struct CapsuleAxis {
  Vector3<double> half = Vector3<double>::Zero();
  double radius = 0.0;
};
CapsuleAxis CapsuleAround(const UrdfShape& shape) {
  CapsuleAxis line;
  if (shape.kind == UrdfShape::Kind::kBox) {
    int longest = 0;
    const double length = shape.size.maxCoeff(&longest);
    line.half[longest] = 0.5 * length;
    line.radius = 0.5 * std::sqrt(std::max(0.0, shape.size.squaredNorm() - length * length));
    return line;
  }
  line.radius = shape.size[0];
  if (shape.kind == UrdfShape::Kind::kCylinder) line.half[2] = 0.5 * shape.size[1];
  return line;
}

void AppendShapes(const UrdfLink& link, int on, const Isometry& frame_from_link, UrdfBodies* bodies) {
  int number = 0;
  for (const UrdfShape& shape : link.shapes) {
    if (shape.kind == UrdfShape::Kind::kMesh) {
      if (bodies->meshes.empty() || bodies->meshes.back() != link.name) bodies->meshes.push_back(link.name);
      continue;
    }
    const Isometry frame_from_shape = frame_from_link * AsIsometry(shape.link_from_shape);
    const CapsuleAxis line = CapsuleAround(shape);
    LinkCapsule capsule;
    capsule.name = link.name + (++number > 1 ? " " + std::to_string(number) : "");
    capsule.on = on;
    capsule.from = frame_from_shape * Vector3<double>(-line.half);
    capsule.to = frame_from_shape * line.half;
    capsule.radius = line.radius;
    bodies->capsules.push_back(capsule);
  }
  if (link.shapes.empty()) bodies->bare.push_back(link.name);
  bodies->moving.insert(bodies->moving.end(), link.moving_beside.begin(), link.moving_beside.end());
}

}  // namespace

UrdfBodies BodiesFromUrdf(const UrdfChain& urdf, const Chain& chain, const std::string& file_in_messages) {
  const Chain described = RobotFromUrdf(urdf, file_in_messages).chain;
  const std::vector<std::string> names = JointNames(chain.joints);
  const bool same = described.num_joints() == chain.num_joints() &&
                    std::all_of(described.joints.begin(), described.joints.end(), [&](const Joint& joint) {
                      return chain.FindJoint(joint.name) == described.FindJoint(joint.name);
                    });
  if (!same) {
    throw InputError({file_in_messages, 0, ""}, "the joints of the URDF are not those of the robot",
                     "state base_link and tip_link so that they are " + Enumerate(names, 12));
  }
  const std::vector<Isometry> between = Between(chain, described, file_in_messages);
  UrdfBodies bodies;
  int on = LinkCapsule::kBase;
  Isometry frame_from_link = Isometry::Identity();
  AppendShapes(urdf.links.front(), on, frame_from_link, &bodies);
  for (size_t i = 0; i < urdf.joints.size(); ++i) {
    const UrdfJoint& joint = urdf.joints[i];
    const Isometry parent_from_joint = AsIsometry(joint.parent_from_joint);
    const Isometry fixed = joint.is_upward ? parent_from_joint.inverse() : parent_from_joint;
    if (joint.is_fixed()) {
      frame_from_link = frame_from_link * fixed;
    } else {
      on = chain.FindJoint(joint.name);
      frame_from_link = between[on] * FrameFromJoint(joint);
      if (joint.is_upward) frame_from_link = frame_from_link * fixed;
    }
    AppendShapes(urdf.links[i + 1], on, frame_from_link, &bodies);
  }
  return bodies;
}

}  // namespace sagitta
