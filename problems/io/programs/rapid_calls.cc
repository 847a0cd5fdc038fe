#include "problems/io/programs/rapid_calls.h"

#include <algorithm>

#include "problems/io/pattern.h"

namespace sagitta {
namespace {

bool IsDigits(const std::string& text) { return text.find_first_not_of("0123456789") == std::string::npos; }

}  // namespace

std::string RapidNameAt(const ProgramCode& source, TextRange range) {
  const std::string& code = source.text();
  if (code.find_first_not_of(" \n", range.first) < range.second) return "";
  for (const ProgramCode::Quote& quote : source.quotes()) {
    if (quote.at < range.first || quote.at >= range.second) continue;
    const size_t module_end = quote.text.rfind(':');
    return UpperCase(quote.text.substr(module_end == std::string::npos ? 0 : module_end + 1));
  }
  return "";
}

namespace {

// %"grip"% wherever it stands; %%% is the head of a file.
void AddLateBound(const ProgramCode& source, std::vector<RapidCallByName>* calls) {
  const std::string& code = source.text();
  size_t open = std::string::npos;
  for (size_t i = 0; i < code.size(); ++i) {
    if (code[i] != '%') continue;
    const size_t end = std::min(code.find_first_not_of('%', i), code.size());
    if (end > i + 1) {
      i = end - 1;
    } else if (open == std::string::npos) {
      open = i;
    } else {
      calls->push_back({open, RapidNameAt(source, {open + 1, i}), false, false});
      open = std::string::npos;
    }
  }
}

// CallByVar "grip", 1 calls grip1.
void AddCallsByVariable(const ProgramCode& source, std::vector<RapidCallByName>* calls) {
  const std::string& code = source.text();
  for (const size_t at : PlacesOf(code, "CALLBYVAR")) {
    const size_t begin = at + std::string("CALLBYVAR").size(), end = std::min(code.find(';', begin), code.size());
    const std::vector<TextRange> parts = PartsOf(code, begin, end);
    RapidCallByName call = {at, RapidNameAt(source, {begin, std::min(code.find(',', begin), end)}), false, false};
    const TextRange number = parts.size() > 1 ? parts[1] : TextRange();
    const std::string digits = code.substr(number.first, number.second - number.first);
    call.any_number = digits.empty() || !IsDigits(digits);
    if (!call.any_number && !call.name.empty()) call.name += digits;
    calls->push_back(call);
  }
}

// MoveLSync p1, v100, z10, gun \WObj:=jig, "grip" \TLoad:=piece;
void AddCallsOfMotions(const ProgramCode& source, std::vector<RapidCallByName>* calls) {
  static const std::regex motion = MakeCodePattern("\\bS?MOVE(?:ABSJ|[JLC])SYNC\\b");
  const std::string& code = source.text();
  for (const std::smatch& match : AllMatches(code.begin(), code.end(), motion)) {
    const size_t begin = static_cast<size_t>(match.position(0) + match.length(0));
    const size_t end = std::min(code.find(';', begin), code.size());
    const size_t comma = code.find_last_of(',', end);
    if (comma == std::string::npos || comma < begin) continue;
    const size_t stop = std::min(code.find('\\', comma), end);
    calls->push_back({begin, RapidNameAt(source, {comma + 1, stop}), false, true});
  }
}

}  // namespace

std::vector<RapidCallByName> RapidCallsByName(const ProgramCode& source) {
  std::vector<RapidCallByName> calls;
  AddLateBound(source, &calls);
  AddCallsByVariable(source, &calls);
  AddCallsOfMotions(source, &calls);
  return calls;
}

bool MayCall(const RapidCallByName& call, const std::string& routine) {
  const size_t length = call.name.size();
  if (length == 0 || !call.any_number) return length == 0 || routine == call.name;
  return routine.size() > length && routine.compare(0, length, call.name) == 0 && IsDigits(routine.substr(length));
}

void FindRapidCallsElsewhere(const ProgramCode& source, RobotProgram* program) {
  static const std::regex routine = MakeCodePattern("\\bPROC (\\w+)");
  const std::string& code = source.text();
  const std::vector<std::smatch> own = AllMatches(code.begin(), code.end(), routine);
  for (const RapidCallByName& call : RapidCallsByName(source)) {
    const bool is_here =
        std::any_of(own.begin(), own.end(), [&](const auto& match) { return MayCall(call, match[1]); });
    if (is_here && !call.name.empty()) continue;
    const std::string name = call.name.empty() ? "one whose name is computed" : call.name;
    program->calls_elsewhere.emplace(name, source.LineAt(call.at));
  }
}

}  // namespace sagitta
