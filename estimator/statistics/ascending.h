// Lists of numbers that ascend, each number once.
#pragma once

#include <algorithm>
#include <vector>

namespace sagitta {

// Numbers of one list or two as such a list.
inline std::vector<int> EachOnce(std::vector<int> numbers, const std::vector<int>& more = {}) {
  numbers.insert(numbers.end(), more.begin(), more.end());
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

// Where a number stands in such a list, or would.
inline size_t PlaceIn(const std::vector<int>& ascending, int number) {
  return std::lower_bound(ascending.begin(), ascending.end(), number) - ascending.begin();
}

}  // namespace sagitta
