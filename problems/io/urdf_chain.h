// One serial chain out of a URDF: its joints from base to tip, read by urdfdom.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/geometry.h"

namespace sagitta {

// The links between which the chain runs; an empty name is found where only one can be meant.
struct UrdfEnds {
  std::string base_link;
  std::string tip_link;
};

struct UrdfJoint {
  enum class Type { kFixed, kRevolute, kPrismatic };
  // The joint follows another: multiplier * q_driver + offset.
  struct Mimic {
    std::string driver;
    double multiplier = 1.0;
    double offset = 0.0;  // rad or m
  };

  std::string name;
  Type type = Type::kFixed;
  Pose<double> parent_from_joint;                   // origin at q = 0, m
  Vector3<double> axis = Vector3<double>::UnitZ();  // unit vector, joint frame
  std::optional<double> min, max;                   // rad or m
  std::optional<Mimic> mimic;
  bool is_upward = false;  // the chain passes it from child to parent

  bool is_fixed() const { return type == Type::kFixed; }
};

// A collision geometry. size, m: sphere {radius}, cylinder {radius, length} along its z, box {x, y, z}.
struct UrdfShape {
  enum class Kind { kSphere, kCylinder, kBox, kMesh };
  Kind kind = Kind::kMesh;
  Vector3<double> size = Vector3<double>::Zero();
  Pose<double> link_from_shape;
};

// A link of the chain with the shapes of whatever is fixed to it outside the chain.
struct UrdfLink {
  std::string name;
  std::vector<UrdfShape> shapes;
  std::vector<std::string> moving_beside;  // links that a joint outside the chain moves: their shapes are left out
};

struct UrdfChain {
  std::string robot_name;
  UrdfEnds ends;
  std::vector<std::string> other_tips;  // links without a child that the chain does not end at
  std::vector<UrdfJoint> joints;        // base to tip, fixed ones included
  std::vector<UrdfLink> links;          // base to tip, one more: joints[i] is between links[i] and links[i + 1]
};

// Throws InputError: not a URDF, a joint that is neither fixed nor revolute nor
// prismatic, no such link, no joint between the links, or several links that
// the chain may end at (they are listed).
UrdfChain ReadUrdfChain(const std::string& text, const std::string& file_in_messages, const UrdfEnds& ends);

}  // namespace sagitta
