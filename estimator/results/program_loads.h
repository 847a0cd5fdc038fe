// What hangs on the arm at each point of a robot program: as the program states it, or as the user does.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "estimator/results/estimate_json.h"
#include "estimator/results/program_compensation.h"
#include "problems/io/programs/robot_program.h"

namespace sagitta {

inline constexpr char kDefaultName[] = "default";  // of a tool, frame or load where the program names none

struct ProgramLoads {
  Experiment loading;                 // of the estimate, with the loads of the program in addition to its own
  std::vector<std::string> of_point;  // by point of the program: name of its load in `loading`
  std::vector<std::string> unclear;   // by point: why its load is not known; "": it is
  bool needs_flange = false;          // a centre of mass stands in the controller's flange
  std::vector<std::string> notes;
};

// A load of the program is all that hangs on the flange, the tool of the estimate included. An arm that nothing bends
// carries every load alike. `scene.load` decides where it is stated.
ProgramLoads LoadsOfProgram(const KnownRobot& known, const RobotProgram& program, const ProgramScene& scene);

}  // namespace sagitta
