#include "problems/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace sagitta {
namespace {

// "-0.00" is 0.00.
std::string WithoutSignOfZero(const std::string& text) {
  const bool is_zero =
      text.find_first_of("123456789") == std::string::npos && text.find_first_of("in") == std::string::npos;
  return is_zero && !text.empty() && text[0] == '-' ? text.substr(1) : text;
}

}  // namespace

std::string Fixed(double value, int decimals) {
  return std::isnan(value) ? "-" : WithoutSignOfZero(fmt::format("{:.{}f}", value, decimals));
}

std::string FormatNumber(double value) {
  char buffer[64];
  const std::to_chars_result result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return std::string(buffer, result.ptr);
}

std::string Significant(double value, int digits) {
  if (std::isnan(value)) return "-";
  const std::string text = fmt::format("{:.{}g}", value, digits);
  double rounded = value;  // stays so where it is infinite
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  const bool would_be_a_power = std::abs(rounded) >= std::pow(10.0, digits);  // 1.66e+03
  return would_be_a_power && std::abs(rounded) < 1e6 ? Fixed(rounded, 0) : WithoutSignOfZero(text);
}

std::string InMillimetres(double metres) { return Significant(1e3 * metres, 3) + " mm"; }

std::string PValueInWords(double p_value) { return p_value < 1e-300 ? "p < 1e-300" : "p = " + Significant(p_value, 2); }

std::string WholePercent(double share) { return Fixed(100.0 * share, 0) + " %"; }

std::string Enumerate(const std::vector<std::string>& items, size_t most) {
  std::string words;
  const size_t shown = std::min(items.size(), most);
  for (size_t i = 0; i < shown; ++i) {
    if (i > 0) words += i + 1 == items.size() ? " and " : ", ";
    words += items[i];
  }
  if (shown < items.size()) words += " and " + std::to_string(items.size() - shown) + " more";
  return words;
}

std::string Joined(const std::vector<std::string>& items, const char* separator) {
  std::string text;
  for (size_t i = 0; i < items.size(); ++i) text += (i > 0 ? separator : "") + items[i];
  return text;
}

std::vector<std::string> SplitText(const std::string& text, char separator) {
  std::vector<std::string> parts;
  size_t begin = 0;
  for (size_t end = 0; end != std::string::npos; begin = end + 1) {
    end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end == std::string::npos ? end : end - begin));
  }
  return parts;
}

std::string LowerCaseOf(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

}  // namespace sagitta
