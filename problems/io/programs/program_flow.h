// What a program sets and what then holds until it is set again: tool, base, load, and the point where the arm is. The
// order of the text is not that of the run: a routine starts with what its callers have set, a call leaves what the
// routine may have set, after branches it is what one of them has set, and in a loop it may be what is set further
// down. Nothing is run: where the text does not decide, there are several values.
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
  kLeave,  // EXIT, break: out of a loop
  kEnd,    // of whatever is open (URScript)
  kJoin,   // a label, an error handler: the program comes here from anywhere
  kCall
};

struct FlowEvent {
  size_t at = 0;
  FlowKind kind = FlowKind::kJoin;
  std::string name;           // of a routine
  size_t until = 0;           // of what is opened here, and of an error handler: where it ends
  bool is_main = false;       // a routine that starts with nothing set
  bool is_interrupt = false;  // it runs at any time: a trap, a thread, an error handler that the program goes on from
};

// Group 1 of `pattern`: a key of `kinds`; group 2: the name of a routine.
std::vector<FlowEvent> FlowEventsOf(const std::string& code, const std::regex& pattern,
                                    const std::map<std::string, FlowKind>& kinds);
// An IF without THEN ends with its statement.
std::vector<FlowEvent> WithEndsOfShortBranches(const std::string& code, const std::vector<FlowEvent>& events);

struct FlowVariable {
  std::regex setter;           // in the code: how a statement begins that sets it
  bool value_is_text = false;  // its value is the text that `setter` finds
};

// Stand for a value that is not known, next to one that is.
inline constexpr char kSetElsewhere[] = "one that another line sets";
inline constexpr char kSetBelow[] = "one that is set further down in the loop";

using FlowValues = std::set<std::string>;

class ProgramFlow {
 public:
  // Every variable is "", nothing set, where the program starts.
  ProgramFlow(const std::string& code, std::vector<FlowEvent> events, const std::vector<FlowVariable>& variables);

  void MoveTo(size_t position);  // forwards only
  void Set(size_t variable, const std::string& value);
  void SetUnknown(size_t variable) { values_[variable] = {"", kSetElsewhere}; }
  const FlowValues& Of(size_t variable) const { return values_[variable]; }
  // Of every variable but `kept`, for what is set for one motion alone.
  const std::vector<FlowValues>& All() const { return values_; }
  void SetAllBut(size_t kept, const std::vector<FlowValues>& values);

 private:
  using State = std::vector<FlowValues>;
  struct Setter {
    size_t at = 0;
    std::string text;
  };
  struct Block {
    FlowKind kind = FlowKind::kBranch;
    State at_entry, of_branches;
    bool has_branch = true, has_else = false, is_main = false;
  };

  void FindEnds();
  void FindCalls(const std::string& code);
  std::set<size_t> SetWithin(size_t begin, size_t end) const;  // variables
  bool IsSetAlike(size_t variable) const;
  bool IsInMain() const;
  bool AlwaysSets(const std::string& routine, size_t variable) const;
  void AddUnknown(size_t variable, const char* mark);
  void FindConstants();
  void Pass(const FlowEvent& event);
  void EnterRoutine(const FlowEvent& routine);
  void LeaveLoop();
  void EndBranch(Block* block);
  void Close(const Block& block);
  void CloseDownTo(bool is_routine);

  std::vector<FlowEvent> events_;
  std::vector<FlowVariable> variables_;
  std::vector<std::vector<Setter>> setters_;      // by variable
  std::map<std::string, std::set<size_t>> sets_;  // by routine: variables, those of routines that it calls included
  std::set<size_t> interrupted_;                  // variables that may be set at any time
  std::map<size_t, FlowValues> constants_;        // set to one value, before the first call
  std::map<std::string, State> at_call_;          // by routine: at the calls so far
  bool has_called_ = false;
  State values_;
  std::vector<Block> open_;
  size_t next_ = 0;
};

// A motion goes to the point with one of these loads.
void UseLoads(const FlowValues& loads, bool is_first, ProgramPoint* point);
// ... comes from one of these points, which are numbers: "" is where the program starts.
void ComeFrom(const FlowValues& points, ProgramPoint* point);

}  // namespace sagitta
