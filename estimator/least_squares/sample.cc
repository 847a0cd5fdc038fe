#include "estimator/least_squares/sample.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sagitta {

std::vector<int> SampleConfigurations(const Measurements& data, const std::vector<int>& observations, size_t columns,
                                      double most) {
  const double numbers = 3.0 * static_cast<double>(observations.size()) * static_cast<double>(columns);
  const auto every = static_cast<std::uint32_t>(std::max(1.0, std::ceil(numbers / most)));
  std::vector<int> sample;
  for (const int i : observations) {
    // Scattered by Knuth's multiplicative hash: stations or loads may alternate.
    const auto c = static_cast<std::uint32_t>(data.shots[data.observations[i].shot].configuration);
    if ((c * 2654435761u >> 16) % every == 0) sample.push_back(i);
  }
  return sample;
}

}  // namespace sagitta
