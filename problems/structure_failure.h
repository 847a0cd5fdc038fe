// How a check of a structure in memory says what is wrong: an InputError without a file, whose key is the item.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "problems/input_error.h"

namespace sagitta {

[[noreturn]] void FailStructure(const std::string& item, const std::string& what, const std::string& hint = "");

// "compliance 2"
std::string Numbered(const char* what, size_t index);

// No NaN, and not so large that its square leaves no digit to a metre that is added. Ranges that are narrower are the
// readers' (problems/limits.h).
void CheckIsNumber(double value, const std::string& item, const char* what);

template <typename Values>
void CheckAreNumbers(const Values& values, const std::string& item, const char* what) {
  for (const double value : values) CheckIsNumber(value, item, what);
}

// NaN is what was not measured.
template <typename Values>
void CheckAreNumbersOrNaN(const Values& values, const std::string& item, const char* what) {
  for (const double value : values) {
    if (!std::isnan(value)) CheckIsNumber(value, item, what);
  }
}

// R'R is the identity and det R is 1, to eight digits of a file. `what`: "its rotation".
void CheckIsRotation(const Eigen::Matrix3d& rotation, const std::string& item, const char* what);

// An index into a list of `size`.
void CheckIndex(int index, size_t size, const std::string& item, const char* what);

// A text that a table can hold: UTF-8 without control characters. `what`: "its visit".
void CheckCanBeWritten(const std::string& text, const std::string& item, const char* what);

// Each has a name that can be written and read back, and no two the same.
void CheckNamesDiffer(const std::vector<std::string>& names, const char* what);

}  // namespace sagitta
