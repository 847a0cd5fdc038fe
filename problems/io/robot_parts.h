// Parts of a robot file, for robot_reader.cc and other files that state them.
#pragma once

#include <string>
#include <vector>

#include "models/robot.h"
#include "problems/io/urdf_chain.h"
#include "problems/io/yaml_reader.h"

namespace sagitta {

Dimension DimensionOf(JointType type);
int ReadJointIndex(const YamlValue& value, const std::vector<Joint>& joints);

// urdf: {file, base_link, tip_link}; the file's path is relative to the file that states it.
struct UrdfSource {
  std::string path;
  UrdfEnds ends;
};
UrdfSource ReadUrdfSource(const YamlValue& value, const std::string& stated_in);

std::vector<ElementaryTransform> ReadChain(const YamlValue& value, const std::vector<Joint>& joints);
std::vector<JointCompliance> ReadCompliances(const YamlValue& value, const std::vector<Joint>& joints);
GravityCompensator ReadGravityCompensator(const YamlValue& value, const std::vector<Joint>& joints);

}  // namespace sagitta
