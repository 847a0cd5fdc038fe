// Robot files (sagitta/robot/1, FORMATS section 1).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "models/robot.h"

namespace sagitta {

// Throws InputError. Reads YAML, JSON as its subset, and URDF where one chain can
// be meant (urdf_robot.h). `own_effects`: definitions in addition to the catalogue that the
// file may use; the robot carries them on.
Robot ReadRobotFile(const std::string& path, const std::vector<const EffectDefinition*>& own_effects = {});
Robot ReadRobotText(const std::string& text, const std::string& file_in_messages,
                    const std::vector<const EffectDefinition*>& own_effects = {});

// The robot in the file's keys, lengths in mm, angles in deg; ReadRobotText of
// its dump gives the robot back to 1e-12.
nlohmann::ordered_json RobotToJson(const Robot& robot);
std::string RobotToYaml(const Robot& robot);

}  // namespace sagitta
