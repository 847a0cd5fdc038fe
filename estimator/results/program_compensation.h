// `sagitta compensate --program`: a robot program with its points corrected, and what became of each of them.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estimator/compensation/compensate.h"
#include "estimator/results/compensation_csv.h"
#include "problems/io/programs/robot_program.h"

namespace sagitta {

// What the program does not state.
struct ProgramScene {
  // By the names of the file; "flange" and "world" say how the controller's flange and world stand to those of the
  // robot file, "default" what holds for points that name none.
  std::map<std::string, Pose<double>> tools;   // in the flange
  std::map<std::string, Pose<double>> frames;  // in the world; "world": in the base
  Eigen::VectorXd start;                       // joints where the program starts; empty: not stated
  std::string load;                            // of the estimate, of all points; "": what the program states, else none
  std::map<std::string, ProgramLoad> loads;    // by the names of the file; "default": of points that name none
  std::vector<int> turn_joints;  // from 0: what the turn numbers of FANUC positions count; empty: not stated
};

// A: "NAME=x,y,z,roll,pitch,yaw; NAME=same": mm and deg, fixed axes. `key`: what the user gave it as. Throws
// InputError.
std::map<std::string, Pose<double>> FramesFromText(const std::string& text, const std::string& key);

// A load of the estimate that a program is to be corrected for: its weight is that of the estimate. `key`: what the
// user gave it as. Throws InputError where the estimate does not say it.
void CheckProgramLoad(const KnownRobot& known, const std::string& load, const std::string& key);

// Throws InputError at `key`, which says where the corrected program is to go, where that is the program itself.
void CheckProgramIsKept(const std::string& program, const std::string& out, const std::string& key);

// A: "NAME=mass,x,y,z; …": kg and mm, the centre of mass in the controller's flange. Throws InputError.
std::map<std::string, ProgramLoad> LoadsFromText(const std::string& text, const std::string& key);

// Three joints counted from 1, as the user gives them, or none. Throws InputError.
std::vector<int> TurnJointsFrom(const std::vector<double>& numbers, int joints, const std::string& key);

// Where the arm is when the program starts: deg, of joints that slide mm; none: not stated. Throws InputError.
Eigen::VectorXd StartFrom(const std::vector<double>& numbers, const Chain& chain, const std::string& key);

struct ProgramPointResult {
  int point = -1;
  std::string untouched;                      // why; "": it is corrected
  std::optional<CompensatedTarget> solution;  // where there was something to solve
  std::string moves;                          // of a corrected pose: the joint that moves far; "": none
  std::string leaves;                         // ... joints that left what status, turn or quadrant state; "": none
  std::string outside;                        // of a corrected point: joints beyond where they were measured; "": none
};

struct CompensatedProgram {
  RobotProgram program;
  std::vector<ProgramPointResult> results;  // one per point of the program
  Targets targets;                          // those that were solved
  std::vector<CompensatedTarget> solved;
  std::string text;                 // the corrected program
  std::vector<std::string> beyond;  // what of the points is beyond the conditions that were measured
};

// Throws InputError where a frame or tool is stated neither by the file nor by `stated`, naming all of them, and where
// `stated` has a name that the program does not have. progress hears now and then how many points are done.
CompensatedProgram CompensateProgram(const KnownRobot& known, RobotProgram program, const ProgramScene& stated,
                                     int threads, const std::function<void(size_t done)>& progress = {});

std::string SummaryOf(const CompensatedProgram& result);

}  // namespace sagitta
