#include "problems/io/import/expressions.h"

#include <algorithm>
#include <cmath>

#include "models/constants.h"
#include "problems/io/import/text_table.h"
#include "problems/io/pattern.h"
#include "problems/io/robot_units.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

std::string WithoutBlanks(const std::string& text) {
  std::string kept;
  for (const char c : text) {
    if (c != ' ' && c != '\t' && c != '*') kept += c;
  }
  return kept;
}

// 2*3 and q2*90: a star between digits is no sign that can be left out, and q2 90 is not q290.
bool Multiplies(const std::string& text) {
  static const std::regex kProduct = MakePattern(R"([0-9.]\s*\*[\s*]*[0-9.])");
  return SearchPattern(text, kProduct);
}

// 1.57, 3.1416: no angle in degrees is meant by these digits. With two decimals pi / 2 and pi are off by 0.0008,
// 0.0016.
bool IsRightAngleInRad(double size) {
  const double quarters = std::round(size / (0.5 * kPi));
  return quarters > 0.0 && std::abs(size - quarters * 0.5 * kPi) < 2e-3;
}

// Every way to write it becomes one letter.
std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

}  // namespace

std::optional<TypedNumber> ParseTypedNumber(const std::string& typed, bool decimal_comma) {
  TypedNumber number;
  if (typed.size() > limits::kWordBytes || Multiplies(typed)) return std::nullopt;
  std::string text = WithoutBlanks(typed);
  for (const char* minus : {"−", "–"}) text = Replaced(text, minus, "-");
  for (const char* degrees : {"°", "deg"}) {
    const size_t at = text.find(degrees);
    if (at == std::string::npos || at == 0 || at + std::string(degrees).size() != text.size()) continue;
    number.is_degrees = true;
    text.erase(at);
  }
  for (const char* pi : {"π", "PI", "Pi"}) text = Replaced(text, pi, "pi");
  static const std::regex kMultipleOfPi = MakePattern(R"(([+-]?)([0-9.,]*)pi(?:/([0-9.,]+))?)");
  std::smatch match;
  if (!MatchPattern(text, &match, kMultipleOfPi)) {
    const std::optional<double> value = ParseLocalNumber(text, decimal_comma);
    if (!value) return std::nullopt;
    number.value = *value;
    return number;
  }
  const auto factor = [decimal_comma](const std::string& digits) {
    return digits.empty() ? std::optional<double>(1.0) : ParseLocalNumber(digits, decimal_comma);
  };
  const std::optional<double> times = factor(match[2].str()), over = factor(match[3].str());
  if (!times || !over || *over == 0.0 || number.is_degrees) return std::nullopt;
  number.value = (match[1].str() == "-" ? -1.0 : 1.0) * *times * M_PI / *over;
  if (!std::isfinite(number.value)) return std::nullopt;
  number.uses_pi = true;
  return number;
}

std::optional<JointExpression> ParseJointExpression(const std::string& typed, bool decimal_comma) {
  static const std::regex kTwoNumbers = MakePattern(R"([0-9]\s+[0-9])");
  if (typed.size() > limits::kWordBytes || Multiplies(typed) || SearchPattern(typed, kTwoNumbers)) return std::nullopt;
  const std::string text = WithoutBlanks(Replaced(Replaced(typed, "θ", "theta"), "−", "-"));
  static const std::regex kVariable =
      MakePattern(R"(([+-]?)(?:q|t|th|theta|d|j)_?\{?\(?([0-9]{1,6})\)?\}?([+-].+)?)", true);
  static const std::regex kConstantFirst = MakePattern(R"((.+[0-9i°])([+-])(?:q|th|theta)_?\(?([0-9]{1,6})\)?)", true);
  JointExpression expression;
  std::smatch match;
  std::string offset;
  if (MatchPattern(text, &match, kVariable)) {
    expression.sign = match[1].str() == "-" ? -1.0 : 1.0;
    expression.index = std::stoi(match[2].str());
    offset = match[3].str();
  } else if (MatchPattern(text, &match, kConstantFirst)) {
    expression.sign = match[2].str() == "-" ? -1.0 : 1.0;
    expression.index = std::stoi(match[3].str());
    offset = match[1].str();
  } else {
    return std::nullopt;
  }
  if (offset.empty()) return expression;
  if (offset[0] == '+') offset.erase(0, 1);
  const std::optional<TypedNumber> number = ParseTypedNumber(offset, decimal_comma);
  if (!number) return std::nullopt;
  expression.offset = *number;
  return expression;
}

void AnglesWithoutUnit::Add(const TypedNumber& number) {
  uses_pi_ |= number.uses_pi;
  is_degrees_ |= number.is_degrees;
  if (number.uses_pi) return;
  const double size = std::abs(number.value);
  largest_ = std::max(largest_, size);
  if (number.is_degrees) return;
  all_whole_ &= number.value == std::round(number.value);
  any_small_ |= size > 0.0 && size <= kFullTurn;
}

AnglesWithoutUnit::Unit AnglesWithoutUnit::unit() const {
  const bool some_degrees = is_degrees_ || largest_ > kFullTurn;
  if (uses_pi_) return some_degrees ? Unit::kEach : Unit::kRad;
  // Whole numbers above 4 are degrees of small angles: nobody types 5 or 6 rad.
  return some_degrees || largest_ == 0.0 || (all_whole_ && largest_ > 4.0) ? Unit::kDeg : Unit::kRad;
}

bool AnglesWithoutUnit::is_guess() const {
  if (uses_pi_ || largest_ == 0.0) return false;
  return !is_degrees_ || any_small_;
}

bool AnglesWithoutUnit::IsUndecided(const TypedNumber& number) const {
  const double size = std::abs(number.value);
  if (number.uses_pi || number.is_degrees || size == 0.0 || size > kFullTurn) return false;
  if (!uses_pi_) return unit() == Unit::kDeg && IsRightAngleInRad(size);
  return unit() == Unit::kEach || (size > 4.0 && number.value == std::round(number.value));
}

double AnglesWithoutUnit::ToRad(const TypedNumber& number) const {
  const bool is_rad = number.uses_pi || (unit() == Unit::kRad && !number.is_degrees);
  return is_rad ? number.value : number.value * kDegree;
}

}  // namespace sagitta
