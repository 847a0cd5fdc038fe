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
    // Scattered by Knuth's multiplicative hash (2^32 over the golden ratio): stations or loads may alternate.
    const auto c = static_cast<std::uint32_t>(data.shots[data.observations[i].shot].configuration);
    if ((c * 2654435761u >> 16) % every == 0) sample.push_back(i);
  }
  return sample;
}

std::vector<int> SampleForStep(const Measurements& data, const std::vector<int>& observations, size_t columns) {
  // A step of p columns from n rows errs at them by sqrt(p / n) of the noise, RMS: n = 100 p, n p = 100 p^2.
  constexpr double kSquaredPrecision = 100.0;
  const auto p = static_cast<double>(columns);
  if (AreHeld(3.0 * static_cast<double>(observations.size()), p)) return observations;
  return SampleConfigurations(data, observations, columns,
                              std::clamp(kSquaredPrecision * p * p, kEnoughNumbers, kMostHeld));
}

}  // namespace sagitta
