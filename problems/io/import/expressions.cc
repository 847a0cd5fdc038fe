#include "problems/io/import/expressions.h"

#include <cmath>

#include "problems/io/import/text_table.h"
#include "problems/io/pattern.h"
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

// Every way to write it becomes one letter.
std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

}  // namespace

std::optional<TypedNumber> ParseTypedNumber(const std::string& typed, bool decimal_comma) {
  TypedNumber number;
  if (typed.size() > limits::kWordBytes) return std::nullopt;
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
  if (typed.size() > limits::kWordBytes) return std::nullopt;
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

}  // namespace sagitta
