// The median and other quantiles of values.
#pragma once

#include <algorithm>
#include <cmath>
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

// Quantiles of values, at least one. Definitions of Hyndman and Fan, Sample quantiles in statistical packages (The
// American Statistician 50, 1996).

// Definition 1, the nearest rank: the smallest value that is not exceeded by the share p. In any order, which changes.
inline double NearestRank(double p, std::vector<double>* values) {
  const auto rank = static_cast<size_t>(std::ceil(p * static_cast<double>(values->size())));
  const auto at = values->begin() + static_cast<std::ptrdiff_t>(std::clamp<size_t>(rank, 1, values->size()) - 1);
  std::nth_element(values->begin(), at, values->end());
  return *at;
}

// Definition 6, of ascending values: the order statistic (n + 1) p, linear between.
inline double InterpolatedQuantile(const std::vector<double>& sorted, double p) {
  const auto n = static_cast<double>(sorted.size());
  const double at = std::clamp((n + 1.0) * p - 1.0, 0.0, n - 1.0);
  const auto below = static_cast<size_t>(at);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace sagitta
