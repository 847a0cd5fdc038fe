// Text without what surrounds it.
#pragma once

#include <string_view>

namespace sagitta {

inline constexpr std::string_view kBlanks = " \t\r";  // within a line

// Without the blanks at its ends; what is returned lies in `text`.
std::string_view Trimmed(std::string_view text, std::string_view blanks = " \t\r\n");

}  // namespace sagitta
