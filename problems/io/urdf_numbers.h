// The numbers of a URDF in its text, where the lines are known, which urdfdom's messages do not name.
#pragma once

#include <map>
#include <string>

#include "models/geometry.h"

namespace sagitta {

// Of a joint: where its element is, and what rotations are only typed as, angles of any size.
struct UrdfJointPlace {
  int line = 0;
  Vector3<double> rpy = Vector3<double>::Zero();
};

// By the names of the joints. Throws InputError with line and joint or link where an attribute of origins, axes,
// limits, mimics, inertias or shapes has not the numbers it needs.
std::map<std::string, UrdfJointPlace> CheckUrdfNumbers(const std::string& text, const std::string& file_in_messages);

// Line ends and tabs within attributes as the blanks that they mean in XML; urdfdom's parser leaves them.
std::string WithPlainBlanks(std::string text);

}  // namespace sagitta
