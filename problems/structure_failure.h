// How a check of a structure in memory says what is wrong: an InputError without a file, whose key is the item.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "problems/input_error.h"

namespace sagitta {

// What is checked: a name, or "compliance 2", which becomes a text only where a check fails. Many rows are checked.
class ItemName {
 public:
  ItemName(const char* name) : what_(name) {}         // NOLINT(google-explicit-constructor)
  ItemName(const std::string& name) : what_(name) {}  // NOLINT(google-explicit-constructor); it outlives this
  ItemName(const char* what, size_t index) : what_(what), is_numbered_(true), index_(index) {}

  std::string words() const;

 private:
  std::string_view what_;
  bool is_numbered_ = false;
  size_t index_ = 0;
};

[[noreturn]] void FailStructure(const ItemName& item, const std::string& what, const std::string& hint = "");

// No NaN, and not so large that its square leaves no digit to a metre that is added. Ranges that are narrower are the
// readers' (problems/limits.h).
void CheckIsNumber(double value, const ItemName& item, const char* what);

template <typename Values>
void CheckAreNumbers(const Values& values, const ItemName& item, const char* what) {
  for (const double value : values) CheckIsNumber(value, item, what);
}

// NaN is what was not measured.
template <typename Values>
void CheckAreNumbersOrNaN(const Values& values, const ItemName& item, const char* what) {
  for (const double value : values) {
    if (!std::isnan(value)) CheckIsNumber(value, item, what);
  }
}

// R'R is the identity and det R is 1, to eight digits of a file. `what`: "its rotation".
void CheckIsRotation(const Eigen::Matrix3d& rotation, const ItemName& item, const char* what);

// An index into a list of `size`.
void CheckIndex(int index, size_t size, const ItemName& item, const char* what);

// A text that a table can hold: UTF-8 without control characters. `what`: "its visit".
void CheckCanBeWritten(const std::string& text, const ItemName& item, const char* what);

// Each has a name that can be written and read back, and no two the same.
void CheckNamesDiffer(const std::vector<std::string>& names, const char* what);

}  // namespace sagitta
