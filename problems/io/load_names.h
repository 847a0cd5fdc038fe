// What a load may be called.
#pragma once

#include <algorithm>
#include <string_view>

#include "models/wrench.h"

namespace sagitta {

// "None", "NONE": a load of that name or no load, nothing decides which. The readers refuse it with the words below.
inline bool IsNoneInOtherLetters(std::string_view load) {
  const std::string_view none = kNoLoad;
  const auto is_letter = [](char c, char small) { return (c | 0x20) == small; };  // ASCII: one bit is the case
  return load != none && std::equal(load.begin(), load.end(), none.begin(), none.end(), is_letter);
}

inline constexpr char kLoadOrNone[] = "a load of this name, or no load?";
inline constexpr char kHowNoneIsWritten[] = "no load is written none, in small letters; a load needs another name";

}  // namespace sagitta
