#include "estimator/validation/prior_conflict.h"

#include <algorithm>
#include <cmath>

#include "estimator/estimate/parameter_table.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

// A prior of which the rows leave this share of the variance says all that is known: they cannot contradict it.
constexpr double kRowsSayNothing = 1.0 - 1e-6;

}  // namespace

// With a prior x0 of variance p and rows that say x1 of variance d, as whitened, the estimate x has the variance v,
//
//   1/v = 1/p + 1/d,   x - x0 = (v / d) (x1 - x0),
//
// of which x1 - x0 scatters by p + s^2 d, s the factor of the noise that the estimate goes by.
std::vector<PriorConflict> PriorsAgainstRows(const CalibrationProblem& problem, const Estimate& estimate) {
  const double noise = AppliedNoise(estimate.sigma);
  std::vector<PriorConflict> conflicts;
  double priors = 0.0;
  for (size_t k = 0; k < estimate.estimated.size(); ++k) {
    const int i = estimate.estimated[k];
    const Coordinate& coordinate = estimate.parameters.coordinates()[i];
    if (!(coordinate.prior_sigma > 0.0) || coordinate.effect_prior > 0.0) continue;
    priors += 1.0;
    const auto row = static_cast<Eigen::Index>(k);
    const double prior = std::pow(coordinate.prior_sigma, 2), left = estimate.covariance(row, row) / (noise * noise);
    if (!(left > 0.0) || left > kRowsSayNothing * prior) continue;
    const double own = 1.0 / (1.0 / left - 1.0 / prior);
    const double apart = (estimate.parameters.Value(i) - coordinate.prior_value) * own / left;
    const double scatter = std::sqrt(prior + noise * noise * own);
    conflicts.push_back({i, coordinate.prior_value + apart, noise * std::sqrt(own), std::abs(apart) / scatter});
  }
  const double limit = NormalQuantile(1.0 - 0.5 * problem.experiment().significance / std::max(1.0, priors));
  const auto is_chance = [limit](const PriorConflict& conflict) { return conflict.sigmas <= limit; };
  conflicts.erase(std::remove_if(conflicts.begin(), conflicts.end(), is_chance), conflicts.end());
  std::stable_sort(conflicts.begin(), conflicts.end(),
                   [](const auto& a, const auto& b) { return a.sigmas > b.sigmas; });
  return conflicts;
}

}  // namespace sagitta
