// Do two estimates, of disjoint parts of the data or by two methods, agree within what they say of themselves?
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/bounded_step.h"
#include "estimator/statistics/distributions.h"

namespace sagitta::test {

struct Agreement {
  int compared = 0;
  int inside = 0;         // |difference| within t sqrt(sigma_a^2 + sigma_b^2)
  std::vector<double> z;  // difference over its 95 % half-width, times 1.96
  int failed = 0;         // splits of which a part could not be fitted

  void Add(const Agreement& other) {
    compared += other.compared;
    inside += other.inside;
    z.insert(z.end(), other.z.begin(), other.z.end());
    failed += other.failed;
  }
  double share() const { return compared > 0 ? inside / static_cast<double>(compared) : 0.0; }
  // Factor on the intervals that makes 95 % of the differences fit.
  double Inflation() const {
    std::vector<double> size;
    for (const double value : z) size.push_back(std::abs(value));
    std::sort(size.begin(), size.end());
    return size.empty() ? 0.0 : size[static_cast<size_t>(0.95 * (size.size() - 1))] / 1.96;
  }
};

// Fits only the observations of configurations for which `use` is true, from `start`.
inline Estimate EstimatePart(CalibrationProblem problem, const ParameterSet& start,
                             const std::function<bool(const Observation&)>& use) {
  for (Observation& observation : problem.mutable_data()->observations) observation.excluded = !use(observation);
  return EstimateFrom(problem, start);
}

// Parameters (by prefix of the name) that both know, on the same condition: those
// that depend on held ones count where both hold the same.
inline void Compare(const Estimate& a, const Estimate& b, const std::string& prefix, Agreement* agreement) {
  bool same = a.held.coordinates == b.held.coordinates;
  for (const int i : a.held.coordinates) same = same && a.table[i].value == b.table[i].value;
  for (const int i : a.estimated) {
    const ParameterEstimate& p = a.table[i];
    const ParameterEstimate& q = b.table[i];
    if (!q.free || (!same && (p.conditional || q.conditional)) || p.name.rfind(prefix, 0) != 0) continue;
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

// Over the estimated coordinates, in standard deviations of `reference`.
inline double LargestDeviation(const Estimate& estimate, const Estimate& reference) {
  const Eigen::VectorXd difference = TangentDifference(estimate.parameters, reference.parameters);
  double largest = 0.0;
  for (const int c : reference.estimated) {
    largest = std::max(largest, std::abs(difference[c]) / reference.table[c].sigma);
  }
  return largest;
}

// Random halves of the configurations, fitted from the estimate of all. `after` is called with the number of splits
// that are done.
inline Agreement CompareRandomHalves(const CalibrationProblem& problem, int splits, unsigned seed,
                                     const std::function<void(int)>& after = {}) {
  std::mt19937_64 random(seed);
  const ParameterSet start = EstimateJointly(problem).parameters;
  Agreement agreement;
  for (int split = 0; split < splits; ++split) {
    std::vector<int> order(problem.data().configurations.size());
    std::iota(order.begin(), order.end(), 0);
    for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
    std::vector<bool> first(order.size());
    for (size_t i = 0; i < order.size() / 2; ++i) first[order[i]] = true;
    const auto half = [&](bool which) {
      return EstimatePart(problem, start, [&](const Observation& observation) {
        return first[problem.data().shots[observation.shot].configuration] == which;
      });
    };
    const Estimate a = half(true), b = half(false);
    const bool usable = IsUsable(a.status) && IsUsable(b.status);
    if (usable) Compare(a, b, "", &agreement);
    agreement.failed += !usable;
    if (after) after(split + 1);
  }
  return agreement;
}

}  // namespace sagitta::test
