#include "tools/requirement.h"

#include <gflags/gflags.h>

#include <iostream>
#include <nlohmann/json.hpp>

#include "problems/input_error.h"
#include "problems/io/trimmed.h"
#include "problems/io/units.h"
#include "problems/text.h"
#include "tools/run_command.h"

DEFINE_string(require, "", "'PATH<NUMBER,…' in the result JSON (< <= > >= ==); not met: exit status 1");

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void Fail(const std::string& what, const std::string& hint) {
  throw InputError({"", 0, "--require"}, what, hint);
}

Requirement ParseRequirement(const std::string& text) {
  const std::string example = "for example --require='validation.distance_rms_mm<0.3'";
  const size_t begin = text.find_first_of("<>=");
  if (begin == std::string::npos) Fail("'" + text + "' compares nothing", example);
  const size_t end = text.find_first_not_of("<>=", begin);
  Requirement requirement;
  requirement.text = std::string(Trimmed(text, " "));
  requirement.path = std::string(Trimmed(text.substr(0, begin), " "));
  requirement.comparison = text.substr(begin, end == std::string::npos ? end : end - begin);
  const std::string& c = requirement.comparison;
  if (c != "<" && c != "<=" && c != ">" && c != ">=" && c != "==")
    Fail("'" + c + "' compares nothing", "use < <= > >= ==");
  const std::optional<double> bound =
      ParseNumber(end == std::string::npos ? "" : std::string(Trimmed(text.substr(end), " ")));
  if (requirement.path.empty()) Fail("'" + text + "' names no figure", example);
  if (!bound) Fail("'" + text + "' compares with no number: only numbers are compared", example);
  requirement.bound = *bound;
  return requirement;
}

// Of no observations every figure is 0, which meets any limit.
void RefuseEmpty(const Json& map, const std::string& path, const std::string& key) {
  for (const char* count : {"observations", "pairs"}) {
    if (!map.is_object() || key == count || map.value(count, Json()) != 0) continue;
    Fail("'" + path + "' is of no measurements: " + count + " is 0",
         "hold rows out (--holdout=0.3), or measure what it judges");
  }
}

double NumberAt(const Json& result, const std::string& path) {
  const Json* here = &result;
  for (const std::string& key : SplitText(path, '.')) {
    if (here->is_array() && !key.empty() && key.find_first_not_of("0123456789") == std::string::npos &&
        key.size() < 9 && std::stoul(key) < here->size()) {
      here = &(*here)[std::stoul(key)];
      continue;
    }
    if (!here->is_object() || !here->contains(key)) {
      std::vector<std::string> known;
      if (here->is_object()) {
        for (const auto& [name, value] : here->items()) known.push_back(name);
      }
      Fail("the result has no '" + path + "'", SpellingHint(key, known));
    }
    RefuseEmpty(*here, path, key);
    here = &(*here)[key];
  }
  if (!here->is_number()) Fail("'" + path + "' is no number in this result", "");
  return here->get<double>();
}

bool IsMet(double value, const Requirement& requirement) {
  const std::string& c = requirement.comparison;
  if (c == "<") return value < requirement.bound;
  if (c == "<=") return value <= requirement.bound;
  if (c == ">") return value > requirement.bound;
  return c == ">=" ? value >= requirement.bound : value == requirement.bound;
}

}  // namespace

std::vector<Requirement> ParseRequirements(const std::string& text) {
  std::vector<Requirement> requirements;
  if (text.empty()) return requirements;
  for (const std::string& part : SplitText(text, ',')) requirements.push_back(ParseRequirement(part));
  return requirements;
}

std::vector<std::string> UnmetRequirements(const std::vector<Requirement>& requirements, const Json& result) {
  std::vector<std::string> unmet;
  for (const Requirement& requirement : requirements) {
    const double value = NumberAt(result, requirement.path);
    if (IsMet(value, requirement)) continue;
    unmet.push_back("required " + requirement.text + ", but " + requirement.path + " is " + FormatNumber(value));
  }
  return unmet;
}

int EndWith(const std::vector<std::string>& unmet) {
  for (const std::string& sentence : unmet) std::cerr << "sagitta: " << sentence << "\n";
  return unmet.empty() ? 0 : kRequirementNotMet;
}

}  // namespace sagitta
