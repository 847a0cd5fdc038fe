// A URDF's serial chain as a chain of elementary transforms.
//
// A joint is its origin (xyz, then rpy = Rz(yaw) Ry(pitch) Rx(roll)) and its
// motion about or along its axis. Its six error parameters are
//
//   <joint>.x, .y, .z            m, added to the origin's xyz (parent's axes)
//   <joint>.roll, .pitch, .yaw   rad, about the x, y, z axes of the joint frame
//
// Rotation errors turn the joint frame itself and are not added to rpy: at a
// pitch of 90 degrees roll and yaw of rpy turn about the same axis, and one of
// three tilts would be lost. With rpy = 0 both are the same. The error about a
// revolute joint's own axis stands on the joint: it is the joint's offset.
// Fixed joints carry no errors; a mimic joint becomes a coupling.
#pragma once

#include <string>

#include "models/robot.h"
#include "problems/io/urdf_chain.h"

namespace sagitta {

// Throws InputError for a mimic whose driver is not in the chain, is a mimic
// itself or is of the other kind.
Robot RobotFromUrdf(const UrdfChain& urdf, const std::string& file_in_messages);

Robot ReadUrdfText(const std::string& text, const std::string& file_in_messages, const UrdfEnds& ends = {});
Robot ReadUrdfFile(const std::string& path, const UrdfEnds& ends = {});

// By the name's ending or the first character of the text.
bool IsUrdf(const std::string& path, const std::string& text);

// The elementary axis that the unit vector lies on (1e-12 rad), with its sign.
struct SignedAxis {
  Axis axis = Axis::kZ;
  double sign = 1.0;
};
std::optional<SignedAxis> ElementaryAxis(const Vector3<double>& unit);

}  // namespace sagitta
