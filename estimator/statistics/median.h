#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace sagitta {

// The middle value; of an even count the upper of the two in the middle, so that it is always one of the values.
// 0 where there are none.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace sagitta
