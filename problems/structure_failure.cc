#include "problems/structure_failure.h"

#include <algorithm>
#include <set>

#include "problems/io/text_checks.h"

namespace sagitta {
namespace {

constexpr double kLargestSi = 1e9;    // of whatever quantity
constexpr double kOrthogonal = 1e-6;  // of R'R from the identity: what eight digits of a file leave

bool IsPlainText(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace

std::string ItemName::words() const { return std::string(what_) + (is_numbered_ ? " " + std::to_string(index_) : ""); }

void FailStructure(const ItemName& item, const std::string& what, const std::string& hint) {
  throw InputError({"", 0, item.words()}, what, hint);
}

void CheckIsNumber(double value, const ItemName& item, const char* what) {
  if (std::abs(value) <= kLargestSi) return;  // false of NaN
  FailStructure(item, std::string(what) + " is no number below 10^9 (SI)");
}

void CheckIndex(int index, size_t size, const ItemName& item, const char* what) {
  if (index >= 0 && index < static_cast<int>(size)) return;
  FailStructure(item, std::string(what) + " " + std::to_string(index) + " does not exist, there are " +
                          std::to_string(size) + " (numbers begin at 0)");
}

void CheckIsRotation(const Eigen::Matrix3d& rotation, const ItemName& item, const char* what) {
  const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (off < kOrthogonal && rotation.allFinite() && rotation.determinant() > 0.0) return;
  FailStructure(item, std::string(what) + " is no rotation matrix");
}

void CheckCanBeWritten(const std::string& text, const ItemName& item, const char* what) {
  if (IsPlainText(text)) return;
  if (HasControlCharacter(text)) {
    FailStructure(Printable(ValidUtf8(item.words())),
                  std::string(what) + " '" + Printable(ValidUtf8(text)) + "' holds a control character");
  }
  if (ValidUtf8(text) != text) {
    FailStructure(Printable(ValidUtf8(item.words())),
                  std::string(what) + " '" + ValidUtf8(text) + "' is no text in UTF-8");
  }
}

void CheckNamesDiffer(const std::vector<std::string>& names, const char* what) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.empty()) FailStructure(what, "one has no name");
    CheckCanBeWritten(name, what, "the name");
    if (!seen.insert(name).second) FailStructure(what, "two have the name '" + name + "'", "give each its own name");
  }
}

}  // namespace sagitta
