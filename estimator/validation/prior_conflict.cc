#include "estimator/validation/prior_conflict.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/calibration/prior_pull.h"
#include "estimator/estimate/parameter_table.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

// A prior of which the rows leave this share of the variance says all that is known: they cannot contradict it.
constexpr double kRowsSayNothing = 1.0 - 1e-6;

// SI, of an effect where the rows scatter as they do; 0 where nobody stated one.
double StatedPrior(const CalibrationProblem& problem, const Coordinate& coordinate) {
  if (coordinate.has_stated_prior()) return coordinate.prior_sigma;
  const auto& parameters = problem.model().parameters();
  const auto stated = std::find_if(parameters.begin(), parameters.end(),
                                   [&](const ModelParameter& own) { return own.name == coordinate.name; });
  return stated == parameters.end() || !(stated->prior_sigma > 0.0) ? 0.0 : coordinate.effect_prior;
}

// Of what the rows say without the prior, SI^2. A fit with weights of its own makes less of the rows than it could: of
// the variance of its estimate (v / p)^2 p is the prior's, the rest is theirs, (v / d)^2 times.
double VarianceOfRows(const CalibrationProblem& problem, const Estimate& estimate, Eigen::Index row, double prior,
                      double own) {
  const double left = estimate.fit_covariance(row, row), noise = AppliedNoise(estimate.sigma);
  if (problem.weight_roots.empty()) return noise * noise * own * estimate.noise_report.loss_inflation;
  const double all = estimate.model_covariance(row, row) / (noise * noise);
  return noise * noise * std::max(0.0, all - left * left / prior) * own * own / (left * left);
}

}  // namespace

// With a prior x0 of variance p and rows that say x1 of variance d, by the weights of the fit, the estimate x has the
// variance v,
//
//   1/v = 1/p + 1/d,   x - x0 = (v / d) (x1 - x0),
//
// of which x1 - x0 scatters by p + s^2 d, s the factor of the noise that the estimate goes by: known as the noise is,
// Student's t by Welch and Satterthwaite. v is that of the fit, whatever the intervals go by.
std::vector<PriorConflict> PriorsAgainstRows(const CalibrationProblem& problem, const Estimate& estimate) {
  std::vector<PriorConflict> conflicts;
  if (estimate.fit_covariance.rows() != static_cast<Eigen::Index>(estimate.estimated.size())) return conflicts;
  const double noise_dof = ModelDof(estimate);
  double priors = 0.0;
  for (size_t k = 0; k < estimate.estimated.size(); ++k) {
    const int i = estimate.estimated[k];
    const Coordinate& coordinate = estimate.parameters.coordinates()[i];
    const double stated = StatedPrior(problem, coordinate);
    if (!(stated > 0.0)) continue;
    priors += 1.0;
    const auto row = static_cast<Eigen::Index>(k);
    const double prior = std::pow(coordinate.prior_sigma, 2), left = estimate.fit_covariance(row, row);
    if (!(left > 0.0) || left > kRowsSayNothing * prior) continue;
    const double own = 1.0 / (1.0 / left - 1.0 / prior);
    const double apart = (estimate.parameters.Value(i) - coordinate.prior_value) * own / left;
    const double rows = VarianceOfRows(problem, estimate, row, prior, own);
    const double variance = stated * stated;
    const double dof = WelchDof(variance, std::numeric_limits<double>::infinity(), rows, noise_dof);
    conflicts.push_back({i, stated, coordinate.prior_value + apart, std::sqrt(rows),
                         std::abs(apart) / std::sqrt(variance + rows), dof});
  }
  const double tail = 0.5 * problem.experiment().significance / std::max(1.0, priors);
  const auto is_chance = [tail](const PriorConflict& conflict) {
    return conflict.sigmas <= StudentQuantile(1.0 - tail, conflict.dof);
  };
  conflicts.erase(std::remove_if(conflicts.begin(), conflicts.end(), is_chance), conflicts.end());
  std::stable_sort(conflicts.begin(), conflicts.end(),
                   [](const auto& a, const auto& b) { return a.sigmas > b.sigmas; });
  return conflicts;
}

}  // namespace sagitta
