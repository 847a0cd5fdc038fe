// What a program sets and what then holds until it is set again: tool, base, load. The order of the text is not that of
// the run: a routine starts with what its callers have set, a call leaves what the routine has set, after branches it
// is what one of them has set, and in a loop it may be what is set further down. Nothing is run: where the text does
// not decide, there are several values, and the point is left.
#pragma once

#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "problems/io/programs/robot_program.h"

namespace sagitta {

enum class FlowKind {
  kRoutine,
  kRoutineEnd,
  kBranch,  // IF
  kSwitch,  // SWITCH, TEST: nothing runs between it and its first case
  kMiddle,  // ELSEIF, CASE
  kElse,    // ELSE, DEFAULT: one of the branches runs for certain
  kBranchEnd,
  kLoop,
  kLoopEnd,
  kEnd,   // of whatever is open (URScript)
  kJoin,  // a label, an error handler: the program comes here from anywhere
  kCall
};

struct FlowEvent {
  size_t at = 0;
  FlowKind kind = FlowKind::kJoin;
  std::string name;      // of a routine
  size_t until = 0;      // of what is opened here: where it ends
  bool is_main = false;  // a routine that starts with nothing set
};

// Group 1 of `pattern`: a key of `kinds`; group 2: the name of a routine.
std::vector<FlowEvent> FlowEventsOf(const std::string& code, const std::regex& pattern,
                                    const std::map<std::string, FlowKind>& kinds);

struct FlowVariable {
  std::regex setter;              // in the code
  std::set<std::string> unknown;  // its values where another routine decides
  bool value_is_text = false;     // its value is the text that `setter` finds
};

// Stands for a value that is not known, next to one that is.
inline constexpr char kSetElsewhere[] = "one that another line sets";

using FlowValues = std::set<std::string>;

class ProgramFlow {
 public:
  // Every variable is "", nothing set, where the program starts.
  ProgramFlow(const std::string& code, std::vector<FlowEvent> events, const std::vector<FlowVariable>& variables);

  void MoveTo(size_t position);  // forwards only
  void Set(size_t variable, const std::string& value) { values_[variable] = last_[variable] = {value}; }
  const FlowValues& Of(size_t variable) const { return values_[variable]; }
  // Of every variable, for what is set for one motion alone.
  const std::vector<FlowValues>& All() const { return values_; }
  void SetAll(const std::vector<FlowValues>& values) { values_ = values; }

 private:
  using State = std::vector<FlowValues>;
  struct Setter {
    size_t at = 0;
    std::string text;
  };
  struct Block {
    FlowKind kind = FlowKind::kBranch;
    State at_entry, of_branches;
    bool has_branch = true, has_else = false;
  };

  void FindEnds();
  void FindCalls(const std::string& code);
  std::set<size_t> SetWithin(size_t begin, size_t end) const;  // variables
  bool IsSetAlike(size_t variable) const;
  void Pass(const FlowEvent& event);
  void EnterRoutine(const FlowEvent& routine);
  void EndBranch(Block* block);
  void Close(const Block& block);
  void CloseDownTo(bool is_routine);

  std::vector<FlowEvent> events_;
  std::vector<FlowVariable> variables_;
  std::vector<std::vector<Setter>> setters_;      // by variable
  std::map<std::string, std::set<size_t>> sets_;  // by routine: variables, those of routines that it calls included
  State values_, last_;
  std::vector<Block> open_;
  size_t next_ = 0;
};

// A motion goes to the point with one of these loads.
void UseLoads(const FlowValues& loads, bool is_first, ProgramPoint* point);

}  // namespace sagitta
