// Parts of a robot file, for robot_reader.cc only.
#pragma once

#include <vector>

#include "models/robot.h"
#include "problems/io/yaml_reader.h"

namespace sagitta {

Dimension DimensionOf(JointType type);
int ReadJointIndex(const YamlValue& value, const std::vector<Joint>& joints);

std::vector<ElementaryTransform> ReadChain(const YamlValue& value, const std::vector<Joint>& joints);
std::vector<JointCompliance> ReadCompliances(const YamlValue& value, const std::vector<Joint>& joints);
GravityCompensator ReadGravityCompensator(const YamlValue& value, const std::vector<Joint>& joints);

}  // namespace sagitta
