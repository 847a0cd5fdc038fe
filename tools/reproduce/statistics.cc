#include "tools/reproduce/statistics.h"

#include <algorithm>
#include <cmath>

namespace sagitta {

double MeanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / values.size();
}

double RmsOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / values.size());
}

double DeviationOf(const std::vector<double>& values) {
  const double mean = MeanOf(values), n = static_cast<double>(values.size());
  return std::sqrt(std::max(0.0, (RmsOf(values) * RmsOf(values) - mean * mean) * n / (n - 1.0)));
}

double LargestOf(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

double NormalityPValue(const std::vector<double>& values) {
  const double mean = MeanOf(values), n = static_cast<double>(values.size());
  double second = 0.0, third = 0.0, fourth = 0.0;
  for (const double value : values) {
    const double square = (value - mean) * (value - mean);
    second += square / n;
    third += square * (value - mean) / n;
    fourth += square * square / n;
  }
  const double skewness = third / std::pow(second, 1.5), excess = fourth / (second * second) - 3.0;
  return std::exp(-0.5 * n / 6.0 * (skewness * skewness + 0.25 * excess * excess));  // chi-square, 2 dof
}

MaxwellFit FitMaxwell(std::vector<double> lengths) {
  std::sort(lengths.begin(), lengths.end());
  MaxwellFit fit;
  fit.sigma = RmsOf(lengths) / std::sqrt(3.0);
  const double n = static_cast<double>(lengths.size());
  for (size_t i = 0; i < lengths.size(); ++i) {
    const double x = lengths[i] / fit.sigma;
    const double below = std::erf(x / std::sqrt(2.0)) - std::sqrt(2.0 / M_PI) * x * std::exp(-0.5 * x * x);
    fit.gap = std::max({fit.gap, std::abs(below - i / n), std::abs((i + 1) / n - below)});
  }
  // Kolmogorov: P = 2 sum (-1)^(k-1) exp(-2 k^2 t^2) of a sigma that is known. This one is of the same lengths, which
  // the gap is then smaller to: an upper bound of P.
  const double t = fit.gap * (std::sqrt(n) + 0.12 + 0.11 / std::sqrt(n));  // Stephens 1970
  double p = 0.0;
  for (int k = 1; k <= 100; ++k) p += (k % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * k * k * t * t);
  fit.p_value = std::clamp(p, 0.0, 1.0);
  return fit;
}

}  // namespace sagitta
