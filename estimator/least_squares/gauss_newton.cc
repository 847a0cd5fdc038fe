#include "estimator/least_squares/gauss_newton.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sagitta {
namespace {

constexpr double kNoGain = 1e-9;        // of chi-square, round-off of the equilibria
constexpr double kFirstDamping = 1e-4;  // of the columns' squared norms: ten times the damping after every failure,
constexpr double kMostDamping = 1e6;    // up to steps of a millionth of the gradient's
constexpr double kNear = 1e-3;          // of the cost: springs and loads overshoot on steps that promise more

bool Falls(const Linearization& there, double cost) {
  return there.valid && there.residual.squaredNorm() <= cost * (1.0 + kNoGain) + kNoGain;
}

// |r|^2 - |r + J d|^2: by how much chi-square falls where the model is linear.
double Promised(const Linearization& here, const BoundedStep& step) {
  return here.residual.squaredNorm() - (here.residual + here.jacobian * step.delta).squaredNorm();
}

// Where joints deviate, the covariance of the rows moves with the parameters: what is sought is J' C^-1 r = 0, not the
// least of r' C^-1 r, and along what is measured poorly the two are apart. Near the cost a whole step is good if it
// leaves at most half of itself (Deuflhard, Newton Methods for Nonlinear Problems, 2004: natural monotonicity).
bool Nears(const Linearization& there, const ParameterSet& parameters, double cost, const BoundedStep& step) {
  if (!there.valid || !(there.residual.squaredNorm() <= cost * (1.0 + kNear))) return false;
  const BoundedStep left = SolveBounded(there, parameters);
  return left.valid && left.size <= 0.5 * step.size;
}

// `step`: undamped. `there`: rows at the end; null: nobody asks, and a step that is near is not checked.
StepOutcome Descend(const RowsAt& rows_at, const Linearization& here, BoundedStep step, double* damping,
                    ParameterSet* parameters, FittedRows* there) {
  const double cost = here.residual.squaredNorm();
  if (*damping > 0.0) step = SolveBounded(here, *parameters, *damping);
  while (step.valid) {
    ParameterSet next = *parameters;
    Move(here.columns, step.delta, 1.0, &next);
    const bool is_near =
        there == nullptr && *damping == 0.0 && step.pinned.empty() && Promised(here, step) <= kNear * cost;
    FittedRows rows;
    if (!is_near) rows = rows_at(next, here.columns);
    if (is_near || Falls(rows.rows, cost) || (*damping == 0.0 && Nears(rows.rows, next, cost, step))) {
      *damping = *damping > kFirstDamping ? 0.1 * *damping : 0.0;
      *parameters = std::move(next);
      if (there != nullptr) *there = std::move(rows);
      return StepOutcome::kTaken;
    }
    *damping = std::max(kFirstDamping, 10.0 * *damping);
    if (*damping > kMostDamping) return StepOutcome::kNoDescent;
    step = SolveBounded(here, *parameters, *damping);
  }
  return StepOutcome::kSingular;
}

}  // namespace

GaussNewtonResult GaussNewton(const RowsAt& rows_at, const std::vector<int>& columns, const ParameterSet& start,
                              const GaussNewtonOptions& options) {
  GaussNewtonResult result;
  result.parameters = start;
  result.fitted = rows_at(start, columns);
  if (!result.fitted.rows.valid || !std::isfinite(result.cost())) return result;
  result.outcome = StepOutcome::kTaken;
  for (double damping = 0.0; result.outcome == StepOutcome::kTaken && result.steps < options.max_steps;) {
    result.left = SolveBounded(result.fitted.rows, result.parameters);
    // sqrt(chi-square / rows): steps are measured in standard deviations of the noise seen, whatever was stated.
    const double noise = std::sqrt(result.cost() / std::max(1, result.fitted.equations));
    if (result.left.valid && result.left.size < options.tolerance * std::max(options.least_noise, noise)) {
      result.converged = true;
      return result;
    }
    FittedRows there;
    result.outcome = Descend(rows_at, result.fitted.rows, result.left, &damping, &result.parameters, &there);
    if (result.outcome == StepOutcome::kTaken) result.fitted = std::move(there);
    ++result.steps;
  }
  return result;
}

StepOutcome TakeOneStep(const RowsAt& rows_at, const Linearization& here, ParameterSet* parameters) {
  double damping = 0.0;
  return Descend(rows_at, here, SolveBounded(here, *parameters), &damping, parameters, nullptr);
}

}  // namespace sagitta
