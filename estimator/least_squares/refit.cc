#include "estimator/least_squares/refit.h"

#include <algorithm>
#include <cmath>

#include "estimator/least_squares/normal_equations.h"
#include "problems/range.h"

namespace sagitta {
namespace {

constexpr Range kCoordinateOrNone{"the index of a coordinate, or -1,", -1.0, 1e9};

void WeighRows(const std::vector<double>& weights, Linearization* linearization) {
  for (size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] == 1.0) continue;
    if (linearization->num_columns() > 0) linearization->jacobian.middleRows(3 * k, 3) *= std::sqrt(weights[k]);
    linearization->residual.segment<3>(3 * k) *= std::sqrt(weights[k]);
  }
}

FittedRows WeighedRows(const NormalEquations& equations, const ParameterSet& parameters,
                       const std::vector<int>& columns, const std::vector<double>& weights) {
  const RowBatches& batches = equations.batches();
  if (!AreHeld(3.0 * batches.num_observations(), static_cast<double>(columns.size()))) {
    const NormalSums sums = equations.Sum(parameters, columns, weights);
    return {Condense(sums), sums.rows};
  }
  Linearization here = Linearize(batches, parameters, columns);
  if (here.valid) AppendPriors(parameters, &here);
  if (here.valid) WeighRows(weights, &here);
  return {here, here.num_rows()};
}

// Of the coordinate that is kept: no column, but part of the fit.
double PriorPenalty(const ParameterSet& parameters, int kept) {
  if (kept < 0 || !parameters.coordinates()[kept].has_prior()) return 0.0;
  const double off = PriorResidual(parameters.coordinates()[kept], parameters.Value(kept));
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

void CheckOptions(const RefitOptions& options) {
  const std::vector<double>& weights = options.weights;
  const auto bad = std::find_if(weights.begin(), weights.end(), [](double w) { return !allowed::kWeight.Has(w); });
  if (bad != weights.end()) CheckIn(allowed::kWeight, *bad, "RefitOptions.weights");
  CheckIn(kCoordinateOrNone, options.kept, "RefitOptions.kept");
}

Refit RefitFrom(const CalibrationProblem& problem, const ParameterSet& start, const RefitOptions& options) {
  CheckOptions(options);
  std::vector<int> columns = start.EstimatedCoordinates();
  columns.erase(std::remove(columns.begin(), columns.end(), options.kept), columns.end());
  const std::vector<int> observations = problem.CalibrationObservations();
  const NormalEquations equations(problem, observations, FitRoots(problem, observations, kFallbackSigma),
                                  LatentTreatment::kMarginalise, 1);
  const auto rows_at = [&](const ParameterSet& parameters, const std::vector<int>& of) {
    return WeighedRows(equations, parameters, of, options.weights);
  };
  GaussNewtonResult found = GaussNewton(rows_at, columns, start, options.steps);
  Refit refit;
  refit.converged = found.converged;
  refit.chi2 = found.cost() + PriorPenalty(found.parameters, options.kept);
  refit.equations = found.fitted.equations;
  refit.linearization = std::move(found.fitted.rows);
  refit.parameters = std::move(found.parameters);
  refit.left = std::move(found.left);
  return refit;
}

}  // namespace sagitta
