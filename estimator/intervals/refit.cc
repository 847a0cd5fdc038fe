#include "estimator/intervals/refit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace sagitta {
namespace {

constexpr double kFallbackSigma = 1e-3;  // m
constexpr double kNoGain = 1e-9;         // of chi-square, round-off of the equilibria
constexpr int kMaxHalvings = 8;

void Weigh(const std::vector<double>& weights, Linearization* linearization) {
  for (size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] == 1.0) continue;
    linearization->jacobian.middleRows(3 * k, 3) *= std::sqrt(weights[k]);
    linearization->residual.segment<3>(3 * k) *= std::sqrt(weights[k]);
  }
}

struct Step {
  bool valid = false;
  Eigen::VectorXd delta;  // one per column
  Eigen::MatrixXd root;   // of (J'J)^-1; zero rows where a bound rules
  double size = 0.0;      // in standard deviations
};

// The Gauss-Newton step of the columns listed in `active`; the others move by `delta`.
bool SolveActive(const Eigen::MatrixXd& normal, const Eigen::VectorXd& gradient, const std::vector<int>& active,
                 Step* step) {
  const Eigen::MatrixXd reduced = normal(active, active);
  const Eigen::VectorXd scale = reduced.diagonal().cwiseSqrt();
  if (!(scale.size() == 0 || scale.minCoeff() > 0.0)) return false;
  const Eigen::MatrixXd scaled = scale.cwiseInverse().asDiagonal() * reduced * scale.cwiseInverse().asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factor(scaled);
  if (factor.info() != Eigen::Success) return false;
  Eigen::VectorXd pinned = step->delta;
  pinned(active).setZero();
  const Eigen::VectorXd right = -(gradient + normal * pinned)(active);
  step->delta(active) = scale.cwiseInverse().cwiseProduct(factor.solve(right.cwiseQuotient(scale)));
  const auto n = static_cast<int>(active.size());
  const Eigen::MatrixXd inverse = factor.matrixU().solve(Eigen::MatrixXd::Identity(n, n));
  step->root.setZero(normal.rows(), n);
  step->root(active, Eigen::all) = scale.cwiseInverse().asDiagonal() * inverse;
  return true;
}

// With lower bounds: what the step would push below stops there, the rest is solved again.
Step BoundedStep(const Linearization& here, const ParameterSet& parameters) {
  const int n = here.num_columns();
  const Eigen::MatrixXd normal = here.jacobian.transpose() * here.jacobian;
  const Eigen::VectorXd gradient = here.jacobian.transpose() * here.residual;
  Step step;
  step.delta.setZero(n);
  std::vector<int> active(n);
  for (int c = 0; c < n; ++c) active[c] = c;
  for (bool changed = true; changed;) {
    if (!SolveActive(normal, gradient, active, &step)) return step;
    changed = false;
    std::vector<int> inside;
    for (const int c : active) {
      const double lowest = parameters.coordinates()[here.columns[c]].lower - parameters.Value(here.columns[c]);
      const bool is_below = step.delta[c] < lowest;
      if (is_below) step.delta[c] = std::min(0.0, lowest);
      if (!is_below) inside.push_back(c);
      changed |= is_below;
    }
    active = inside;
  }
  for (const int c : active) step.size = std::max(step.size, std::abs(step.delta[c]) / step.root.row(c).norm());
  step.valid = std::isfinite(step.size);
  return step;
}

// Of the coordinate that is kept: no column, but part of the fit.
double PriorPenalty(const ParameterSet& parameters, int kept) {
  if (kept < 0 || parameters.coordinates()[kept].prior_sigma <= 0.0) return 0.0;
  const Coordinate& coordinate = parameters.coordinates()[kept];
  const double off = (parameters.Value(kept) - coordinate.prior_value) / coordinate.prior_sigma;
  return off * off;
}

void Move(const std::vector<int>& columns, const Eigen::VectorXd& delta, double share, ParameterSet* parameters) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(parameters->num_coordinates());
  for (size_t c = 0; c < columns.size(); ++c) all[columns[c]] = share * delta[c];
  parameters->Plus(all);
}

}  // namespace

Linearization LinearizeFit(const CalibrationProblem& problem, const ParameterSet& parameters,
                           const std::vector<int>& columns) {
  const std::vector<int> observations = problem.CalibrationObservations();
  Linearization fit =
      Linearize(problem, parameters, observations, columns, ObservationNoise(problem, observations, kFallbackSigma));
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
  for (int i = 0, halvings = 0; i < options.max_steps; ++i) {
    Linearization here = LinearizeFit(problem, next, columns);
    if (here.valid) Weigh(options.weights, &here);
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
    const Step step = BoundedStep(refit.linearization, refit.parameters);
    if (!step.valid) return refit;
    refit.root = step.root;
    const double noise = std::sqrt(chi2 / std::max(1, refit.linearization.num_rows()));
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
