// Robots as URDF: a new file, or an existing one whose origins are edited.
//
// URDF holds kinematics only: compliances, effects and the compensator stay out.
#pragma once

#include <string>
#include <vector>

#include "models/robot.h"
#include "problems/io/urdf_chain.h"

namespace sagitta {

// One link per joint, frames as the chain has them right after the joint, and a
// fixed joint to `flange`. Throws InputError for a coupling, which URDF cannot
// state (a mimic joint has no value of its own).
std::string RobotToUrdf(const Robot& robot);

struct EditedUrdf {
  std::string text;
  std::vector<std::string> joints;  // whose origins changed
};

// `text` with origins such that the links of `ends` move as the robot does:
// attributes xyz and rpy of joints that change (by more than 1e-12), everything
// else byte for byte. The robot's joints are the URDF's, in order. A chain that was
// read from a URDF keeps its frames; for any other the URDF's frames are moved
// onto the robot's axes by the least turn and shift, and the last fixed joint absorbs
// the rest. Throws InputError where that is not possible, and where an origin
// would move by more than 100 mm or 10 degrees: then it is another robot.
EditedUrdf EditUrdf(const std::string& text, const std::string& file_in_messages, const UrdfEnds& ends,
                    const Robot& robot);

}  // namespace sagitta
