// Programs of robot controllers as far as targets go: which points a file holds, in which frame and with which tool,
// and where in its text their numbers stand, so that they can be replaced and every other byte stays.
//
// What a file does not state is not assumed: its point then names no frame or tool ("").
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "models/geometry.h"
#include "problems/io/programs/program_dialect.h"

namespace sagitta {

// A number in the text.
struct TextNumber {
  size_t begin = 0, end = 0;  // bytes
  double value = 0.0;         // as written
};

// A pose in the file's notation, and its numbers.
Pose<double> PoseFrom(PoseNotation notation, const std::vector<double>& numbers);
std::vector<double> NumbersOf(PoseNotation notation, const Pose<double>& pose);

// Names that every dialect has, whatever it calls them: no tool, and the controller's world (base) frame.
constexpr const char* kFlangeName = "flange";
constexpr const char* kWorldName = "world";

// What a file says of the joint solution that a pose is meant to be reached by. Empty: nothing.
struct StatedBranch {
  std::optional<bool> wrist_behind;        // the wrist centre is behind joint 1, seen as at the zero pose
  std::optional<bool> elbow_of_zero;       // the elbow is bent to the side to which it is at the zero pose
  std::optional<bool> elbow_past_stretch;  // joint 3 is beyond the value at which the arm is stretched
  std::optional<bool> wrist_negative;      // joint 5 is below 0
  // Joint (from 0) within [low, high], rad.
  std::vector<std::pair<int, std::pair<double, double>>> ranges;
  // FANUC: whole turns of three joints, each within 180 deg of so many; which joints (from 0) the file does not say.
  std::vector<int> turns;
  std::vector<int> turn_joints;   // as the user says; empty: every three in a row that the joints' limits allow
  bool from_before = false;       // the controller chooses the solution that is nearest to where the arm is
  std::vector<double> near;       // rad: ... that is nearest to these joints
  bool also_from_before = false;  // ... `near`, and by the motion before it that to where the arm is
  bool states_anything() const {
    return wrist_behind || elbow_of_zero || elbow_past_stretch || wrist_negative || !ranges.empty() || !turns.empty();
  }
};

// What hangs on the flange, tool and workpiece, as controllers state it.
struct ProgramLoad {
  double mass = 0.0;       // kg
  Vector3<double> centre;  // of mass, m, in the controller's flange
};

// In place of a point that a motion comes from.
constexpr int kPlaceOfStart = -1, kPlaceUnknown = -2;

struct ProgramPoint {
  std::string name;
  int line = 0;
  bool is_joints = false;
  std::vector<TextNumber> numbers;  // of joints, or of the pose in the file's notation
  std::string frame, tool;          // of a pose: names
  std::string load;                 // name of what hangs on the flange there; "": the file says nothing
  std::string other_load;           // of another motion to it; "": there is none
  size_t used_at = 0;    // byte where the first motion goes to it, else where it stands: the order of the way
  std::set<int> before;  // points from which motions come to it
  StatedBranch branch;
  std::string untouched;      // why it stays as it is; "": it is corrected
  bool is_elsewhere = false;  // a motion names it; this file has no numbers of it
};

// A target of a motion command; a circle has two of them.
struct ProgramMotion {
  std::string name;  // "MoveL p10"
  int line = 0;
  int point = -1;          // of the program
  bool is_offset = false;  // it goes on from the point, as Offs and RelTool do
};

struct RobotProgram {
  ProgramDialect dialect = ProgramDialect::kKrl;
  std::string path;
  std::string text;
  std::vector<ProgramPoint> points;                  // in the order of the text
  std::vector<ProgramMotion> motions;                // every one that the text has
  std::map<std::string, Pose<double>> frames;        // in the world frame, stated by the file
  std::map<std::string, Pose<double>> tools;         // in the flange, stated by the file
  std::map<std::string, ProgramLoad> loads;          // stated by the file; points may name others
  std::map<std::string, std::string> unclear_loads;  // of those that points name and `loads` has not: why, if known
  std::vector<std::string> notes;                    // what a reader of the result should know
  std::map<std::string, int> calls_elsewhere;  // routines that are called and are not in this file: line of the first

  // Of its dialect.
  const DialectTraits& traits() const { return TraitsOf(dialect); }
  // Of a joint point: rad.
  std::vector<double> JointValues(const ProgramPoint& point) const;
};

// In the dialect that the ending of its name says. `joints`: of the robot. Throws InputError: an ending of no dialect,
// no target in the file, a point that is cut off.
RobotProgram ReadRobotProgram(const std::string& path, int joints);

// Of tools, frames and loads, by name. One that the program gives two values, or changes as it runs, has none that
// holds everywhere: its name stays, and the user states it.
template <typename Value>
class StatedOnce {
 public:
  void State(const std::string& name, const Value& value, std::map<std::string, Value>* stated) {
    const auto [known, is_new] = stated->emplace(name, value);
    if (is_changed_[name] || (!is_new && !IsSame(known->second, value))) Change(name, stated);
  }
  void Change(const std::string& name, std::map<std::string, Value>* stated) {
    is_changed_[name] = true;
    stated->erase(name);
  }
  bool IsChanged(const std::string& name) const {
    const auto known = is_changed_.find(name);
    return known != is_changed_.end() && known->second;
  }

 private:
  static bool IsSame(const ProgramLoad& a, const ProgramLoad& b) { return a.mass == b.mass && a.centre == b.centre; }
  static bool IsSame(const Pose<double>& a, const Pose<double>& b) {
    return a.rotation == b.rotation && a.translation == b.translation;
  }

  std::map<std::string, bool> is_changed_;
};

// A motion goes to the point with this load.
void UseLoad(const std::string& load, bool is_first, ProgramPoint* point);

// A motion goes to what this file has no numbers of. Its index as a point that stays as it is.
int AddPointElsewhere(const std::string& name, int line, size_t used_at, RobotProgram* program);
constexpr const char* kPointElsewhere = "this file gives it no numbers";
// The same for what is computed or chosen as the program runs.
int AddComputedPoint(const std::string& name, int line, size_t used_at, const std::string& why, RobotProgram* program);

// The text with the numbers of some points replaced: joints in rad, poses in their frame and for their tool.
struct CorrectedPoint {
  int point = -1;
  std::vector<double> joints;
  Pose<double> tool_in_frame;
};
std::string WithCorrectedPoints(const RobotProgram& program, const std::vector<CorrectedPoint>& corrected);

// One reader per dialect, text in, points out.
void ReadKrl(int joints, RobotProgram* program);
void ReadRapid(int joints, RobotProgram* program);
void ReadUrScript(int joints, RobotProgram* program);
void ReadFanuc(int joints, RobotProgram* program);

}  // namespace sagitta
