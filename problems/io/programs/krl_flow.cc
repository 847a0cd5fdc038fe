#include "problems/io/programs/krl_flow.h"

#include "problems/io/pattern.h"
#include "problems/io/programs/program_text.h"

namespace sagitta {
namespace {

// The first routine of a file is its program.
std::vector<FlowEvent> KrlEvents(const std::string& code) {
  static const std::regex words = MakeCodePattern(
      "(?:^|\\n)[ \\t]*(?:GLOBAL[ "
      "\\t]+)?(DEFFCT|DEF|ENDFCT|END|IF|ELSE|ENDIF|SWITCH|CASE|DEFAULT|ENDSWITCH|LOOP|ENDLOOP|"
      "FOR|ENDFOR|WHILE|ENDWHILE|REPEAT|UNTIL|EXIT|RETURN)\\b(?:[ \\t]+(?:\\w+[ \\t]+)?(\\w+)[ \\t]*(?=\\())?");
  static const std::map<std::string, FlowKind> kinds = {
      {"DEF", FlowKind::kRoutine},         {"DEFFCT", FlowKind::kRoutine},
      {"END", FlowKind::kRoutineEnd},      {"ENDFCT", FlowKind::kRoutineEnd},
      {"IF", FlowKind::kBranch},           {"ELSE", FlowKind::kElse},
      {"ENDIF", FlowKind::kBranchEnd},     {"SWITCH", FlowKind::kSwitch},
      {"CASE", FlowKind::kMiddle},         {"DEFAULT", FlowKind::kElse},
      {"ENDSWITCH", FlowKind::kBranchEnd}, {"LOOP", FlowKind::kLoop},
      {"ENDLOOP", FlowKind::kLoopEnd},     {"FOR", FlowKind::kLoop},
      {"ENDFOR", FlowKind::kLoopEnd},      {"WHILE", FlowKind::kLoop},
      {"ENDWHILE", FlowKind::kLoopEnd},    {"REPEAT", FlowKind::kLoop},
      {"UNTIL", FlowKind::kLoopEnd},       {"EXIT", FlowKind::kLeave},
      {"RETURN", FlowKind::kLeave}};
  std::vector<FlowEvent> events = FlowEventsOf(code, words, kinds);
  for (FlowEvent& event : events) {
    if (event.kind != FlowKind::kRoutine) continue;
    event.is_main = true;
    break;
  }
  // INTERRUPT DECL 3 WHEN ... DO STOPPED(), TRIGGER WHEN ... DO GRIP()
  static const std::regex at_any_time = MakeCodePattern("\\b(?:INTERRUPT|TRIGGER)\\b[^\\n]*\\bDO[ \\t]+(\\w+)");
  for (const std::smatch& match : AllMatches(code.begin(), code.end(), at_any_time)) {
    for (FlowEvent& event : events) event.is_interrupt |= event.kind == FlowKind::kRoutine && event.name == match[1];
  }
  if (code.find("GOTO") == std::string::npos) return events;
  static const std::regex label = MakeCodePattern("(?:^|\\n)[ \\t]*(\\w+)[ \\t]*:[ \\t\\r]*(?=\\n)");
  for (const std::smatch& match : AllMatches(code.begin(), code.end(), label)) {
    events.push_back({static_cast<size_t>(match.position(1)), FlowKind::kJoin, "", 0, false, false});
  }
  return events;
}

// is_held: an FDAT of the file may hold the workpiece.
std::vector<FlowVariable> KrlVariables(bool is_held) {
  // Every inline form states an FDAT and hands it to BAS.
  static const std::string part = "(?:[ \\t]*\\.[ \\t]*\\w+)*[ \\t]*=(?!=)", by_data = "|\\bFDAT_ACT[ \\t]*=",
                           bas = "|\\bBAS[ \\t]*\\([ \\t]*#(?:FRAMES|PTP_PARAMS|CP_PARAMS|";
  return {{MakeCodePattern("\\$TOOL" + part + by_data + bas + "TOOL)"), false},
          {MakeCodePattern("\\$BASE" + part + by_data + bas + "BASE)"), false},
          {MakeCodePattern("\\$LOAD" + part + by_data + bas + "TOOL)"), false},
          {MakeCodePattern("\\$IPO_MODE" + part + (is_held ? by_data : "")), false},
          {MakeCodePattern("(?:^|\\n)[ \\t]*(?:S?(?:PTP|LIN|CIRC)(?:_REL)?|SPL)\\b"), false}};
}

}  // namespace

std::optional<int> KrlBitsAt(const std::string& code, TextRange range) {
  static const std::regex written = MakeCodePattern("^'\\s*([BH])\\s*([0-9A-F]{1,8})\\s*'$");
  TextNumber number;
  if (NumberAt(code, range, &number) && number.value == static_cast<int>(number.value)) {
    return static_cast<int>(number.value);
  }
  const std::string text = code.substr(range.first, range.second - range.first);
  std::smatch match;
  if (!SearchPattern(text, &match, written)) return std::nullopt;
  const bool is_binary = match[1] == "B";
  if (is_binary && match[2].str().find_first_not_of("01") != std::string::npos) return std::nullopt;
  return static_cast<int>(std::stoul(match[2], nullptr, is_binary ? 2 : 16));
}

ProgramFlow FlowOfKrl(const std::string& code) {
  return ProgramFlow(code, KrlEvents(code), KrlVariables(code.find("#TCP") != std::string::npos));
}

}  // namespace sagitta
