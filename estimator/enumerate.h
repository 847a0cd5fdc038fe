#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace sagitta {

// "a", "a and b", "a, b and c"; of more than `most` items "a, b and 3 more".
inline std::string Enumerate(const std::vector<std::string>& items, size_t most = std::string::npos) {
  std::string words;
  const size_t shown = std::min(items.size(), most);
  for (size_t i = 0; i < shown; ++i) {
    if (i > 0) words += i + 1 == items.size() ? " and " : ", ";
    words += items[i];
  }
  if (shown < items.size()) words += " and " + std::to_string(items.size() - shown) + " more";
  return words;
}

}  // namespace sagitta
