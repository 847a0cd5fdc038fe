#include "problems/io/programs/rapid_flow.h"

#include <algorithm>

#include "problems/io/pattern.h"

namespace sagitta {
namespace {

// IF without THEN ends with its statement.
std::vector<FlowEvent> RapidEvents(const std::string& code) {
  static const std::regex words = MakePattern(
      "\\b(PROC|FUNC|TRAP|ENDPROC|ENDFUNC|ENDTRAP|IF|ELSEIF|ELSE|ENDIF|TEST|CASE|DEFAULT|ENDTEST|FOR|ENDFOR|WHILE|"
      "ENDWHILE|ERROR|UNDO|BACKWARD)\\b(?:[ \\t]+(?:\\w+[ \\t]+)?(\\w+)[ \\t]*(?=\\())?");
  static const std::map<std::string, FlowKind> kinds = {
      {"PROC", FlowKind::kRoutine},       {"FUNC", FlowKind::kRoutine},       {"TRAP", FlowKind::kRoutine},
      {"ENDPROC", FlowKind::kRoutineEnd}, {"ENDFUNC", FlowKind::kRoutineEnd}, {"ENDTRAP", FlowKind::kRoutineEnd},
      {"IF", FlowKind::kBranch},          {"ELSEIF", FlowKind::kMiddle},      {"ELSE", FlowKind::kElse},
      {"ENDIF", FlowKind::kBranchEnd},    {"TEST", FlowKind::kSwitch},        {"CASE", FlowKind::kMiddle},
      {"DEFAULT", FlowKind::kElse},       {"ENDTEST", FlowKind::kBranchEnd},  {"FOR", FlowKind::kLoop},
      {"ENDFOR", FlowKind::kLoopEnd},     {"WHILE", FlowKind::kLoop},         {"ENDWHILE", FlowKind::kLoopEnd},
      {"ERROR", FlowKind::kJoin},         {"UNDO", FlowKind::kJoin},          {"BACKWARD", FlowKind::kJoin}};
  static const std::regex then = MakePattern("\\bTHEN\\b");
  const std::vector<FlowEvent> found = FlowEventsOf(code, words, kinds);
  std::vector<FlowEvent> events;
  size_t routines = 0;
  for (const FlowEvent& event : found) {
    events.push_back(event);
    routines += event.kind == FlowKind::kRoutine;
    const size_t end = std::min(code.find(';', event.at), code.size());
    if (event.kind != FlowKind::kBranch || SearchPattern(code.substr(event.at, end - event.at), then)) continue;
    events.push_back({end, FlowKind::kBranchEnd, "", 0, false});
  }
  if (code.find("GOTO") != std::string::npos) {
    static const std::regex label = MakePattern("[;\\n][ \\t]*(\\w+)[ \\t]*:(?!=)");
    for (const std::smatch& match : AllMatches(code.begin(), code.end(), label)) {
      events.push_back({static_cast<size_t>(match.position(1)), FlowKind::kJoin, "", 0, false});
    }
  }
  for (FlowEvent& event : events) {
    event.is_main = event.kind == FlowKind::kRoutine && (event.name == "MAIN" || routines == 1);
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  return events;
}

std::vector<FlowVariable> RapidVariables() {
  static const std::vector<FlowVariable> variables = {
      {MakePattern("\\bGRIPLOAD\\s+[^;]*"), {"", kSetElsewhere}, false},
      {MakePattern("\\bPDISP(?:ON|SET|OFF)\\b"), {"", kSetElsewhere}, true},
      {MakePattern("\\bEOFFS(?:ON|SET|OFF)\\b"), {"", kSetElsewhere}, true},
      {MakePattern("\\bCONFJ\\b\\s*(?:\\\\\\s*(?:ON|OFF)\\b)?"), {"", kSetElsewhere}, true},
      {MakePattern("\\bCONFL\\b\\s*(?:\\\\\\s*(?:ON|OFF)\\b)?"), {"", kSetElsewhere}, true}};
  return variables;
}

}  // namespace

ProgramFlow FlowOfRapid(const std::string& code) { return ProgramFlow(code, RapidEvents(code), RapidVariables()); }

}  // namespace sagitta
