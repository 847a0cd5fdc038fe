#include "estimator/least_squares/refit.h"

#include <algorithm>
#include <cmath>

#include "estimator/least_squares/bounded_step.h"
#include "estimator/least_squares/normal_equations.h"

namespace sagitta {
namespace {

constexpr double kNoGain = 1e-9;  // of chi-square, round-off of the equilibria
constexpr int kMaxHalvings = 8;

void Weigh(const std::vector<double>& weights, Linearization* linearization) {
  for (size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] == 1.0) continue;
    if (linearization->num_columns() > 0) linearization->jacobian.middleRows(3 * k, 3) *= std::sqrt(weights[k]);
    linearization->residual.segment<3>(3 * k) *= std::sqrt(weights[k]);
  }
}

// With priors; count: of equations.
Linearization RowsAt(const NormalEquations& equations, const ParameterSet& parameters, const std::vector<int>& columns,
                     const std::vector<double>& weights, int* count) {
  const RowBatches& batches = equations.batches();
  if (!AreHeld(3.0 * batches.num_observations(), static_cast<double>(columns.size()))) {
    const NormalSums sums = equations.Sum(parameters, columns, weights);
    *count = sums.rows;
    return Condense(sums);
  }
  Linearization here = Linearize(batches, parameters, columns);
  if (here.valid) AppendPriors(parameters, &here);
  if (here.valid) Weigh(weights, &here);
  *count = here.num_rows();
  return here;
}

// Of the coordinate that is kept: no column, but part of the fit.
double PriorPenalty(const ParameterSet& parameters, int kept) {
  if (kept < 0 || parameters.coordinates()[kept].prior_sigma <= 0.0) return 0.0;
  const Coordinate& coordinate = parameters.coordinates()[kept];
  const double off = (parameters.Value(kept) - coordinate.prior_value) / coordinate.prior_sigma;
  return off * off;
}

}  // namespace

Linearization LinearizeFit(const CalibrationProblem& problem, const ParameterSet& parameters,
                           const std::vector<int>& columns) {
  const std::vector<int> observations = problem.CalibrationObservations();
  Linearization fit =
      Linearize(problem, parameters, observations, columns, FitRoots(problem, observations, kFallbackSigma));
  if (fit.valid) AppendPriors(parameters, &fit);
  return fit;
}

Refit RefitFrom(const CalibrationProblem& problem, const ParameterSet& start, const RefitOptions& options) {
  std::vector<int> columns = start.EstimatedCoordinates();
  columns.erase(std::remove(columns.begin(), columns.end(), options.kept), columns.end());
  Refit refit;
  refit.parameters = start;
  ParameterSet next = start;
  Eigen::VectorXd delta;
  double share = 1.0;
  const std::vector<int> observations = problem.CalibrationObservations();
  const NormalEquations equations(problem, observations, FitRoots(problem, observations, kFallbackSigma),
                                  LatentTreatment::kMarginalise, 1);
  for (int i = 0, halvings = 0; i < options.max_steps; ++i) {
    int count = 0;
    Linearization here = RowsAt(equations, next, columns, options.weights, &count);
    const double chi2 = here.valid ? here.residual.squaredNorm() + PriorPenalty(next, options.kept)
                                   : std::numeric_limits<double>::infinity();
    const bool first = delta.size() == 0;
    if (!std::isfinite(chi2) || (!first && chi2 > refit.chi2 * (1.0 + kNoGain) + kNoGain)) {
      if (first || ++halvings > kMaxHalvings) return refit;
      share *= 0.5;
      next = refit.parameters;
      Move(columns, delta, share, &next);
      continue;
    }
    halvings = 0;
    share = 1.0;
    refit.parameters = next;
    refit.chi2 = chi2;
    refit.linearization = std::move(here);
    const BoundedStep step = SolveBounded(refit.linearization, refit.parameters);
    if (!step.valid) return refit;
    refit.root = step.root;
    const double noise = std::sqrt(chi2 / std::max(1, count));
    if (step.size < options.tolerance * std::max(1e-9, noise)) {
      refit.converged = true;
      return refit;
    }
    delta = step.delta;
    Move(columns, delta, share, &next);
  }
  return refit;
}

}  // namespace sagitta
