#include "problems/io/programs/calls_elsewhere.h"

#include <algorithm>
#include <set>

#include "problems/io/pattern.h"
#include "problems/io/programs/language_words.h"

namespace sagitta {
namespace {

struct CallsOf {
  std::regex call;     // group 1: the name
  std::regex routine;  // group 1: the name of one that is in the file
};

// A macro of FANUC is called by its name alone, which may have blanks and arguments: "3:  HAND 1 OPEN ;".
const CallsOf& Calls(ProgramDialect dialect) {
  static const CallsOf krl = {MakeCodePattern("(?:\\n|\\bDO) ?([A-Z_]\\w*) ?\\("),
                              MakeCodePattern("\\bDEF(?:FCT \\w+(?:\\[[^\\]]{0,20}\\])?)? (\\w+)")};
  static const CallsOf rapid = {
      MakeCodePattern("(?:;|[^,=+*/\\\\(\\[{-]\\n|\\b(?:THEN|ELSE|DO|:)) ?\\n?([A-Z_]\\w*) ?\\n?"
                      "(?=;|\\\\|,|[ \\n][\\w\\[(+-])"),
      MakeCodePattern("\\b(?:PROC|TRAP|FUNC \\w+) (\\w+)")};
  static const CallsOf ur = {MakeCodePattern("(?:\\n|;|:|\\brun\\b) ?\\n?([A-Za-z_]\\w*) ?\\("),
                             MakeCodePattern("\\b(?:def|thread|sec) (\\w+)")};
  static const CallsOf fanuc = {
      MakeCodePattern(
          "(?:\\b(?:CALL|RUN) |\\n ?\\d{1,6} ?: ?(?!(?:CALL|RUN)\\b)(?=[A-Z_][\\w ]{0,60}(?:\\([^;\\n]{0,200}\\) ?)?;))"
          "([A-Z_]\\w*(?: \\w+){0,5})"),
      MakeCodePattern("/PROG (\\w+)")};
  switch (dialect) {
    case ProgramDialect::kKrl:
      return krl;
    case ProgramDialect::kRapid:
      return rapid;
    case ProgramDialect::kUrScript:
      return ur;
    case ProgramDialect::kFanuc:
      break;
  }
  return fanuc;
}

// The word of which the language may have one: of FANUC the first.
std::string FirstWord(const std::string& name) { return name.substr(0, name.find(' ')); }

}  // namespace

void FindCallsElsewhere(const ProgramCode& code, RobotProgram* program) {
  const CallsOf& of = Calls(program->dialect);
  const std::string& text = code.text();
  std::set<std::string> own;
  for (const std::smatch& match : AllMatches(text.begin(), text.end(), of.routine)) own.insert(match[1]);
  for (auto from = text.begin();;) {
    std::smatch match;
    if (!SearchPattern(from, text.end(), &match, of.call)) break;
    const size_t at = static_cast<size_t>(match[1].first - text.begin());
    from = match[1].second;
    const std::string name = match[1];
    if (own.count(name) > 0 || IsWordOfLanguage(program->dialect, FirstWord(name))) continue;
    program->calls_elsewhere.emplace(name, code.LineAt(at));
  }
}

}  // namespace sagitta
