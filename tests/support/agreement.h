// Do two estimates from disjoint parts of the data agree within what they say of
// themselves?
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "estimator/distributions.h"
#include "estimator/joint_estimator.h"

namespace sagitta::test {

struct Agreement {
  int compared = 0;
  int inside = 0;         // |difference| within t sqrt(sigma_a^2 + sigma_b^2)
  std::vector<double> z;  // difference over its 95 % half-width, times 1.96
  double share() const { return compared > 0 ? inside / static_cast<double>(compared) : 0.0; }
  // Factor on the intervals that makes 95 % of the differences fit.
  double Inflation() const {
    std::vector<double> size;
    for (const double value : z) size.push_back(std::abs(value));
    std::sort(size.begin(), size.end());
    return size.empty() ? 0.0 : size[static_cast<size_t>(0.95 * (size.size() - 1))] / 1.96;
  }
};

// Fits only the observations of configurations for which `use` is true, from
// `start`: what cannot be told is held where the start has it, so that two parts
// hold it at the same value.
inline Estimate EstimatePart(CalibrationProblem problem, const ParameterSet& start,
                             const std::function<bool(const Observation&)>& use) {
  for (Observation& observation : problem.data.observations) observation.excluded = !use(observation);
  return EstimateFrom(problem, start);
}

// Parameters (by prefix of the name) that both know, on the same condition: those
// tied to held ones count where both hold the same.
inline void Compare(const Estimate& a, const Estimate& b, const std::string& prefix, Agreement* agreement) {
  const bool same = a.held.coordinates == b.held.coordinates;
  for (const int i : a.estimated) {
    const ParameterEstimate& p = a.table[i];
    const ParameterEstimate& q = b.table[i];
    if (!q.free || (!same && (p.tied || q.tied)) || p.name.rfind(prefix, 0) != 0) continue;
    const double variance = p.sigma * p.sigma + q.sigma * q.sigma;
    // Welch and Satterthwaite: degrees of freedom of a sum of two variances.
    const double weight = std::pow(p.sigma, 4) / p.dof + std::pow(q.sigma, 4) / q.dof;
    const double t = StudentQuantile(0.975, weight > 0.0 ? variance * variance / weight : 1e9);
    const double difference = p.value - q.value;
    ++agreement->compared;
    agreement->inside += std::abs(difference) <= t * std::sqrt(variance);
    agreement->z.push_back(difference / (t * std::sqrt(variance)) * 1.96);
  }
}

}  // namespace sagitta::test
