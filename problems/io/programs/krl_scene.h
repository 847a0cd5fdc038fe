// What KRL says of tool, base and load: $TOOL, $BASE, $LOAD and $IPO_MODE, set by name, in numbers, by BAS or by the
// FDAT of an inline form, and the numbers of TOOL_DATA[1], BASE_DATA[1], LOAD_DATA[1]. Numbers hold everywhere where
// they stand in a data list or above all that runs; what is given others as the program runs has none.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "problems/io/programs/krl_flow.h"

namespace sagitta {

using KrlFields = std::map<std::string, TextRange>;

class KrlScene {
 public:
  // code: in capitals; both outlive the scene.
  KrlScene(const ProgramCode& code, RobotProgram* program);

  ProgramFlow& flow() { return flow_; }

  // "{E6POS: X 1, Y 2}" -> X, Y with the places of their values.
  KrlFields FieldsAt(size_t open) const;

  // False: the line is about something else.
  bool ReadLine(const std::string& line, size_t begin);
  // ... WITH $TOOL = ..., for what follows.
  void ReadWith(const std::string& line, size_t begin);
  // Names of an FDAT; "": it does not say.
  struct FrameData {
    std::string tool, base, load;
    bool is_held = false;  // the tool stands in the room and the robot holds the workpiece
  };
  const FrameData* FindFrameData(const std::string& name) const;

  // Leaves the points whose tool, base or load has other numbers as the program runs.
  void LeaveChanged() const;

 private:
  void ReadAllFrameData();
  FrameData FrameDataAt(size_t open) const;
  void FindFirstAction();
  bool HoldsFromStart(size_t at) const;
  void Set(const std::string& what, const std::string& value, size_t at);
  void SetByNumber(const std::string& kind, const std::string& number);
  void SetFrameData(const std::string& name);
  void ReadBas(const std::string& what, const std::string& number);
  // Of $TOOL, $BASE, $LOAD = value. Nothing: what it is then is computed.
  std::optional<std::string> NameOf(KrlVariable variable, const std::string& value, size_t at);
  bool IsNamed(const std::string& value) const;
  bool StatePose(KrlVariable variable, const std::string& name);
  bool ReadData(const std::string& line, size_t begin);
  bool ReadChange(const std::string& line);
  void Change(const std::string& kind, const std::string& name);
  std::optional<Pose<double>> PoseAt(size_t open) const;
  std::optional<ProgramLoad> LoadAt(size_t open) const;

  const ProgramCode& source_;
  const std::string& code_;
  RobotProgram& program_;
  ProgramFlow flow_;                             // "": it is not set so far
  std::map<std::string, FrameData> frame_data_;  // by the name of the FDAT
  bool is_frame_data_set_ = false;               // by the last line that set tool or base
  size_t first_action_ = 0, data_begin_ = 0, data_end_ = 0;
  StatedOnce<ProgramLoad> loads_;
  StatedOnce<Pose<double>> tools_, bases_;
};

}  // namespace sagitta
