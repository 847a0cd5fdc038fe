#include "problems/structure_failure.h"

#include <set>

#include "problems/io/text_checks.h"

namespace sagitta {
namespace {

constexpr double kLargestSi = 1e9;  // of whatever quantity

}  // namespace

void FailStructure(const std::string& item, const std::string& what, const std::string& hint) {
  throw InputError({"", 0, item}, what, hint);
}

std::string Numbered(const char* what, size_t index) { return std::string(what) + " " + std::to_string(index); }

void CheckIsNumber(double value, const std::string& item, const char* what) {
  if (std::abs(value) <= kLargestSi) return;  // false of NaN
  FailStructure(item, std::string(what) + " is no number below 10^9 (SI)");
}

void CheckIndex(int index, size_t size, const std::string& item, const char* what) {
  if (index >= 0 && index < static_cast<int>(size)) return;
  FailStructure(item, std::string(what) + " " + std::to_string(index) + " does not exist, there are " +
                          std::to_string(size) + " (numbers begin at 0)");
}

void CheckNamesDiffer(const std::vector<std::string>& names, const char* what) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.empty()) FailStructure(what, "one has no name");
    if (HasControlCharacter(name)) FailStructure(what, "the name '" + Printable(name) + "' holds a control character");
    if (!seen.insert(name).second) FailStructure(what, "two have the name '" + name + "'", "give each its own name");
  }
}

}  // namespace sagitta
