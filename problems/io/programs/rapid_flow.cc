#include "problems/io/programs/rapid_flow.h"

#include <algorithm>

#include "problems/io/pattern.h"
#include "problems/io/programs/rapid_calls.h"

namespace sagitta {
namespace {

// An error handler runs wherever an error comes up, in the routines that its own calls, too. After RETRY and TRYNEXT
// the program goes on there with what the handler has set.
void MarkErrorHandlers(const std::string& code, std::vector<FlowEvent>* events) {
  static const std::regex goes_on = MakeCodePattern("\\b(?:RETRY|TRYNEXT)\\b");
  if (!SearchPattern(code, goes_on)) return;
  for (auto handler = events->begin(); handler != events->end(); ++handler) {
    if (handler->kind != FlowKind::kJoin || code.compare(handler->at, 5, "ERROR") != 0) continue;
    const auto end = std::find_if(handler + 1, events->end(), [](const FlowEvent& event) {
      return event.kind == FlowKind::kJoin || event.kind == FlowKind::kRoutineEnd;
    });
    handler->is_interrupt = true;
    handler->until = end == events->end() ? code.size() : end->at;
  }
}

// Of a call that may be one of several routines each may run, or not.
void AddCall(const RapidCallByName& call, std::vector<FlowEvent>* events) {
  std::vector<std::string> routines;
  for (FlowEvent& event : *events) {
    if (event.kind != FlowKind::kRoutine || event.name.empty() || !MayCall(call, event.name)) continue;
    if (event.is_main && call.name.empty()) continue;
    event.is_interrupt |= call.at_any_time;
    routines.push_back(event.name);
  }
  if (call.at_any_time) return;
  const bool is_certain = routines.size() == 1 && !call.name.empty();
  for (const std::string& name : routines) {
    if (!is_certain) events->push_back({call.at, FlowKind::kBranch, "", 0, false, false});
    events->push_back({call.at, FlowKind::kCall, name, 0, false, false});
    if (!is_certain) events->push_back({call.at, FlowKind::kBranchEnd, "", 0, false, false});
  }
}

std::vector<FlowEvent> RapidEvents(const std::string& code) {
  static const std::regex words = MakeCodePattern(
      "\\b(PROC|FUNC|TRAP|ENDPROC|ENDFUNC|ENDTRAP|IF|ELSEIF|ELSE|ENDIF|TEST|CASE|DEFAULT|ENDTEST|FOR|ENDFOR|WHILE|"
      "ENDWHILE|ERROR|UNDO|BACKWARD|RETURN)\\b(?:[ \\t]+(?:\\w+[ \\t]+)?(\\w+)[ \\t]*(?=\\())?");
  static const std::map<std::string, FlowKind> kinds = {
      {"PROC", FlowKind::kRoutine},       {"FUNC", FlowKind::kRoutine},       {"TRAP", FlowKind::kRoutine},
      {"ENDPROC", FlowKind::kRoutineEnd}, {"ENDFUNC", FlowKind::kRoutineEnd}, {"ENDTRAP", FlowKind::kRoutineEnd},
      {"IF", FlowKind::kBranch},          {"ELSEIF", FlowKind::kMiddle},      {"ELSE", FlowKind::kElse},
      {"ENDIF", FlowKind::kBranchEnd},    {"TEST", FlowKind::kSwitch},        {"CASE", FlowKind::kMiddle},
      {"DEFAULT", FlowKind::kElse},       {"ENDTEST", FlowKind::kBranchEnd},  {"FOR", FlowKind::kLoop},
      {"ENDFOR", FlowKind::kLoopEnd},     {"WHILE", FlowKind::kLoop},         {"ENDWHILE", FlowKind::kLoopEnd},
      {"ERROR", FlowKind::kJoin},         {"UNDO", FlowKind::kJoin},          {"BACKWARD", FlowKind::kJoin},
      {"RETURN", FlowKind::kLeave}};
  std::vector<FlowEvent> events = WithEndsOfShortBranches(code, FlowEventsOf(code, words, kinds));
  MarkErrorHandlers(code, &events);
  if (code.find("GOTO") != std::string::npos) {
    static const std::regex label = MakeCodePattern("[;\\n][ \\t]*(\\w+)[ \\t]*:(?!=)");
    for (const std::smatch& match : AllMatches(code.begin(), code.end(), label)) {
      events.push_back({static_cast<size_t>(match.position(1)), FlowKind::kJoin, "", 0, false, false});
    }
  }
  for (FlowEvent& event : events) {
    event.is_main = event.kind == FlowKind::kRoutine && event.name == "MAIN";
    event.is_interrupt |= event.kind == FlowKind::kRoutine && code.compare(event.at, 4, "TRAP") == 0;
  }
  return events;
}

std::vector<FlowVariable> RapidVariables() {
  static const std::vector<FlowVariable> variables = {
      {MakeCodePattern("\\b(?:GRIPLOAD|SETSYSDATA)\\b"), false},
      {MakeCodePattern("\\bPDISP(?:ON|SET|OFF)\\b"), true},
      {MakeCodePattern("\\bEOFFS(?:ON|SET|OFF)\\b"), true},
      {MakeCodePattern("\\bCONFJ\\b\\s*(?:\\\\\\s*(?:ON|OFF)\\b)?"), true},
      {MakeCodePattern("\\bCONFL\\b\\s*(?:\\\\\\s*(?:ON|OFF)\\b)?"), true},
      {MakeCodePattern("\\b(?:MOVE|TRIGG|SEARCH|ARC|SPOT|DISP)(?:ABSJ|[JLC])"), false}};
  return variables;
}

}  // namespace

ProgramFlow FlowOfRapid(const ProgramCode& source) {
  std::vector<FlowEvent> events = RapidEvents(source.text());
  for (const RapidCallByName& call : RapidCallsByName(source)) AddCall(call, &events);
  return ProgramFlow(source.text(), events, RapidVariables());
}

}  // namespace sagitta
