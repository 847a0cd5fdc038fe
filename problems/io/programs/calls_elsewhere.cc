#include "problems/io/programs/calls_elsewhere.h"

#include <algorithm>
#include <set>

#include "problems/io/pattern.h"

namespace sagitta {
namespace {

// The word of which the language may have one: of FANUC the first.
std::string FirstWord(const std::string& name) { return name.substr(0, name.find(' ')); }

}  // namespace

const CallPatterns& KrlCalls() {
  static const CallPatterns kCalls = {MakeCodePattern("(?:\\n|\\bDO) ?([A-Z_]\\w*) ?\\("),
                                      MakeCodePattern("\\bDEF(?:FCT \\w+(?:\\[[^\\]]{0,20}\\])?)? (\\w+)")};
  return kCalls;
}

const CallPatterns& RapidCalls() {
  static const CallPatterns kCalls = {
      MakeCodePattern("(?:;|[^,=+*/\\\\(\\[{-]\\n|\\b(?:THEN|ELSE|DO|:)) ?\\n?([A-Z_]\\w*) ?\\n?"
                      "(?=;|\\\\|,|[ \\n][\\w\\[(+-])"),
      MakeCodePattern("\\b(?:PROC|TRAP|FUNC \\w+) (\\w+)")};
  return kCalls;
}

const CallPatterns& UrScriptCalls() {
  static const CallPatterns kCalls = {MakeCodePattern("(?:\\n|;|:|\\brun\\b) ?\\n?([A-Za-z_]\\w*) ?\\("),
                                      MakeCodePattern("\\b(?:def|thread|sec) (\\w+)")};
  return kCalls;
}

// A macro of FANUC is called by its name alone, which may have blanks and arguments: "3:  HAND 1 OPEN ;".
const CallPatterns& FanucCalls() {
  static const CallPatterns kCalls = {
      MakeCodePattern(
          "(?:\\b(?:CALL|RUN) |\\n ?\\d{1,6} ?: ?(?!(?:CALL|RUN)\\b)(?=[A-Z_][\\w ]{0,60}(?:\\([^;\\n]{0,200}\\) ?)?;))"
          "([A-Z_]\\w*(?: \\w+){0,5})"),
      MakeCodePattern("/PROG (\\w+)")};
  return kCalls;
}

void FindCallsElsewhere(const ProgramCode& code, RobotProgram* program) {
  const CallPatterns& of = program->traits().calls();
  const std::set<std::string>& words = program->traits().words();
  const std::string& text = code.text();
  std::set<std::string> own;
  for (const std::smatch& match : AllMatches(text.begin(), text.end(), of.routine)) own.insert(match[1]);
  for (auto from = text.begin();;) {
    std::smatch match;
    if (!SearchPattern(from, text.end(), &match, of.call)) break;
    const size_t at = static_cast<size_t>(match[1].first - text.begin());
    from = match[1].second;
    const std::string name = match[1];
    if (own.count(name) > 0 || words.count(FirstWord(name)) > 0) continue;
    program->calls_elsewhere.emplace(name, code.LineAt(at));
  }
}

}  // namespace sagitta
