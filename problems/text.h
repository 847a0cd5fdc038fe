// How numbers and lists read in sentences and tables: one style for messages, reports and the terminal.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sagitta {

inline constexpr char kAxisLetters[] = "xyz";

// "12.30" with two decimals; "-" where the value is not known (NaN). Zero has no sign.
std::string Fixed(double value, int decimals);

// The shortest decimal text that reads back to the same double, as files have it.
std::string FormatNumber(double value);

// Rounded to that many significant digits, without a power of ten up to 1e6: "1660", "0.023". "-": not known.
std::string Significant(double value, int digits);

// A length in m as "0.123 mm", three digits.
std::string InMillimetres(double metres);

// "p = 0.03"; below what a number holds "p < 1e-300".
std::string PValueInWords(double p_value);

// A share as "12 %", to the percent.
std::string WholePercent(double share);

// "a", "a and b", "a, b and c"; of more than `most` items "a, b and 3 more".
std::string Enumerate(const std::vector<std::string>& items, size_t most = std::string::npos);

// All items with the separator between them.
std::string Joined(const std::vector<std::string>& items, const char* separator = ", ");

// The parts between separators, empty ones included; one at least.
std::vector<std::string> SplitText(const std::string& text, char separator);

// A to Z in small letters, all else as it is.
std::string LowerCaseOf(std::string text);

}  // namespace sagitta
