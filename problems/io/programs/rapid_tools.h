// tooldata, wobjdata and loaddata of a RAPID module. What hangs on the flange is the tool's load, its centre of mass in
// the flange, and that of the last GripLoad, its centre of mass in the tool. Names are in capitals.
#pragma once

#include <map>
#include <set>
#include <string>

#include "problems/io/programs/program_text.h"

namespace sagitta {

class RapidTools {
 public:
  // upper: the code in capitals; both outlive the tools.
  RapidTools(const std::string& upper, RobotProgram* program) : code_(upper), program_(*program) {}

  // The value of a declaration, whose bracket opens at `open`.
  void AddTool(const std::string& name, size_t open);
  void AddWorkObject(const std::string& name, size_t open);
  void AddPayload(const std::string& name, size_t open);
  bool IsToolOrWorkObject(const std::string& name) const { return tools_and_objects_.count(name) > 0; }
  // name.part := ..., whatever it is the name of; "": of all that are declared.
  void Change(const std::string& name, const std::string& part);
  // "GUN and PIECE": tool and workpiece as one body. `total`: what \TLoad names in place of both, "": nothing.
  std::string LoadWith(const std::string& tool, const std::string& total, const std::string& gripped);
  bool IsLoadChanged(const std::string& tool, const std::string& gripped) const;
  // Why a point stays that is reached with this tool or work object; "": nothing stands in the way.
  std::string WhyNot(const std::string& tool, const std::string& frame, bool is_joints) const;

 private:
  const std::string& code_;
  RobotProgram& program_;
  std::set<std::string> tools_and_objects_ = {"TOOL0", "WOBJ0"}, declared_;
  std::map<std::string, std::string> refused_;                // tools and work objects: why
  std::map<std::string, ProgramLoad> tool_loads_, payloads_;  // in the flange, in the tool
  StatedOnce<ProgramLoad> stated_tool_loads_, stated_payloads_;
  StatedOnce<Pose<double>> stated_tools_, stated_frames_;
};

}  // namespace sagitta
