#include "problems/io/programs/ur_flow.h"

#include "problems/io/programs/program_text.h"

namespace sagitta {
namespace {

// The last routine that stands in no other is the program: the others have to be known before they are called.
std::vector<FlowEvent> UrEvents(const std::string& code) {
  static const std::regex words = MakeCodePattern(
      "\\b(def|thread|sec|if|elif|else|while|for|end|break|continue|return)\\b(?:\\s+(\\w+)\\s*(?=\\())?");
  static const std::map<std::string, FlowKind> kinds = {
      {"def", FlowKind::kRoutine}, {"thread", FlowKind::kRoutine}, {"sec", FlowKind::kRoutine},
      {"if", FlowKind::kBranch},   {"elif", FlowKind::kMiddle},    {"else", FlowKind::kElse},
      {"while", FlowKind::kLoop},  {"for", FlowKind::kLoop},       {"end", FlowKind::kEnd},
      {"break", FlowKind::kLeave}, {"continue", FlowKind::kLeave}, {"return", FlowKind::kLeave}};
  std::vector<FlowEvent> events = FlowEventsOf(code, words, kinds);
  int depth = 0;
  FlowEvent* main = nullptr;
  for (FlowEvent& event : events) {
    event.is_interrupt = event.kind == FlowKind::kRoutine && code.compare(event.at, 3, "def") != 0;
    if (event.kind == FlowKind::kRoutine && depth == 0 && !event.is_interrupt) main = &event;
    depth += event.kind == FlowKind::kRoutine || event.kind == FlowKind::kBranch || event.kind == FlowKind::kLoop;
    depth -= event.kind == FlowKind::kEnd;
  }
  if (main != nullptr) main->is_main = true;
  return events;
}

}  // namespace

ProgramFlow FlowOfUrScript(const std::string& code) {
  static const std::vector<FlowVariable> variables = {
      {MakeCodePattern("\\bset_tcp\\s*\\("), false},
      {MakeCodePattern("\\bset_(?:target_)?payload(?:_mass|_cog)?\\s*\\("), false},
      {MakeCodePattern("\\b(?:(?:optimove|move)[jlpc]|servo[jc])\\s*\\("), false}};
  return ProgramFlow(code, UrEvents(code), variables);
}

}  // namespace sagitta
