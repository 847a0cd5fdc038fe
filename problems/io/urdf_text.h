// The places of joint origins in a URDF's text, so that they can be edited and
// everything else stays byte for byte. Expat gives the byte offsets.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "models/geometry.h"

namespace sagitta {

// A new origin for a joint; what is absent stays as it is.
struct OriginEdit {
  std::optional<Vector3<double>> xyz;  // m
  std::optional<Vector3<double>> rpy;  // rad
};

// "0.1 0 -0.25", as attributes have them.
std::string UrdfNumbers(const Vector3<double>& v);

// The text with the origins of the named joints edited, by joint name. A joint
// without an origin element gets one. Throws InputError.
std::string WithOrigins(const std::string& text, const std::string& file_in_messages,
                        const std::map<std::string, OriginEdit>& edits);

}  // namespace sagitta
