#include "problems/io/programs/krl_calls.h"

#include <algorithm>
#include <set>

#include "problems/io/pattern.h"

namespace sagitta {
namespace {

// In front of a bracket these call nothing, or compute with what they are handed.
const std::set<std::string>& WordsThatChangeNothing() {
  static const std::set<std::string> words = {
      "",     "IF",    "WHILE", "UNTIL", "SWITCH", "CASE", "FOR",     "TO",      "RETURN", "WAIT", "SEC",
      "AND",  "OR",    "NOT",   "EXOR",  "B_AND",  "B_OR", "ABS",     "SQRT",    "SIN",    "COS",  "TAN",
      "ACOS", "ATAN2", "DO",    "WHEN",  "THEN",   "ELSE", "INVERSE", "FORWARD", "INV_POS"};
  return words;
}

struct Call {
  std::string callee;
  size_t argument = 0;  // from 0
};

// The call whose bracket is open at `at`; what calls nothing has no name.
Call CallAround(const std::string& code, size_t at) {
  Call call;
  int depth = 0;
  for (size_t i = at; i > 0 && code[i - 1] != '\n'; --i) {
    const char c = code[i - 1];
    depth += (c == ')' || c == ']' || c == '}') - (c == '(' || c == '[' || c == '{');
    call.argument += c == ',' && depth == 0;
    if (depth >= 0) continue;
    size_t end = i - 1;
    while (end > 0 && code[end - 1] == ' ') --end;
    size_t begin = end;
    while (begin > 0 && IsWordCharacter(code[begin - 1])) --begin;
    if (c == '(') call.callee = code.substr(begin, end - begin);
    return call;
  }
  return call;
}

// An argument that is the variable or a part of it, no value that is computed of it, but for a chain of frames (A:B),
// which is left alone as well; of a routine's head the parameter (P:OUT), which hides the variable.
bool IsAnArgument(const std::string& code, size_t at, size_t end) {
  static const std::regex behind = MakeCodePattern("^(?: ?\\. ?\\w+){0,9} ?[,):]");
  size_t before = at;
  while (before > 0 && code[before - 1] == ' ') --before;
  if (before == 0 || (code[before - 1] != '(' && code[before - 1] != ',')) return false;
  return SearchPattern(code.substr(end, 400), behind);
}

bool IsByValue(const std::string& code, const Call& call) {
  static const std::regex by_value = MakeCodePattern(": ?IN\\b");
  const std::regex head = MakeCodePattern("\\bDEF(?:FCT \\w+(?:\\[[^\\]]{0,20}\\])?)? " + call.callee + " ?(\\()");
  std::smatch match;
  if (call.callee[0] == '$' || !SearchPattern(code, &match, head)) return false;
  const size_t open = static_cast<size_t>(match.position(1)), end = EndOfBracket(code, open);
  if (end == std::string::npos) return false;
  const std::vector<TextRange> parts = PartsOf(code, open + 1, end - 1);
  if (call.argument >= parts.size()) return false;
  const TextRange part = parts[call.argument];
  return SearchPattern(code.substr(part.first, part.second - part.first), by_value);
}

}  // namespace

std::optional<size_t> HandedToRoutine(const std::string& code, const std::string& name, bool by_value) {
  for (const size_t at : PlacesOf(code, name)) {
    const Call call = CallAround(code, at);
    if (WordsThatChangeNothing().count(call.callee) > 0 || !IsAnArgument(code, at, at + name.size())) continue;
    if (by_value || !IsByValue(code, call)) return at;
  }
  return std::nullopt;
}

}  // namespace sagitta
