#include "problems/io/programs/rapid_flow.h"

#include "problems/io/pattern.h"

namespace sagitta {
namespace {

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
  if (code.find("GOTO") != std::string::npos) {
    static const std::regex label = MakeCodePattern("[;\\n][ \\t]*(\\w+)[ \\t]*:(?!=)");
    for (const std::smatch& match : AllMatches(code.begin(), code.end(), label)) {
      events.push_back({static_cast<size_t>(match.position(1)), FlowKind::kJoin, "", 0, false, false});
    }
  }
  for (FlowEvent& event : events) {
    event.is_main = event.kind == FlowKind::kRoutine && event.name == "MAIN";
    event.is_interrupt = event.kind == FlowKind::kRoutine && code.compare(event.at, 4, "TRAP") == 0;
  }
  return events;
}

std::vector<FlowVariable> RapidVariables() {
  static const std::vector<FlowVariable> variables = {
      {MakeCodePattern("\\bGRIPLOAD\\b"), false},
      {MakeCodePattern("\\bPDISP(?:ON|SET|OFF)\\b"), true},
      {MakeCodePattern("\\bEOFFS(?:ON|SET|OFF)\\b"), true},
      {MakeCodePattern("\\bCONFJ\\b\\s*(?:\\\\\\s*(?:ON|OFF)\\b)?"), true},
      {MakeCodePattern("\\bCONFL\\b\\s*(?:\\\\\\s*(?:ON|OFF)\\b)?"), true},
      {MakeCodePattern("\\b(?:MOVE|TRIGG|SEARCH|ARC|SPOT|DISP)(?:ABSJ|[JLC])"), false}};
  return variables;
}

}  // namespace

ProgramFlow FlowOfRapid(const std::string& code) { return ProgramFlow(code, RapidEvents(code), RapidVariables()); }

}  // namespace sagitta
