#include "estimator/baselines/damped_step.h"

#include <algorithm>
#include <cmath>

#include "estimator/baselines/paper_steps.h"

namespace sagitta {
namespace {

constexpr double kFarStep = 1e-3;  // of the cost, explained by one step: check that it does come down
// Levenberg-Marquardt terms of column-normalised rows, tried in turn.
constexpr double kDampings[] = {0.0, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6};

// Columns that can move: not all zero, not pressed against their bound.
std::vector<int> MovingColumns(const Linearization& here, const ParameterSet& parameters) {
  std::vector<int> moving;
  const Eigen::VectorXd gradient = here.jacobian.transpose() * here.residual;
  for (int c = 0; c < here.num_columns(); ++c) {
    const int i = here.columns[c];
    const bool at_bound = parameters.Value(i) <= parameters.coordinates()[i].lower;
    if (here.jacobian.col(c).isZero(0.0) || (at_bound && gradient[c] >= 0.0)) continue;
    moving.push_back(c);
  }
  return moving;
}

bool SolveDamped(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual, double damping,
                 Eigen::VectorXd* step) {
  if (damping == 0.0) return SolveScaled(jacobian, -residual, step);
  const int n = jacobian.cols(), m = jacobian.rows();
  Eigen::MatrixXd rows(m + n, n);
  rows.topRows(m) = jacobian;
  rows.bottomRows(n) = (std::sqrt(damping) * jacobian.colwise().norm()).asDiagonal();
  Eigen::VectorXd right(m + n);
  right << -residual, Eigen::VectorXd::Zero(n);
  return SolveScaled(rows, right, step);
}

}  // namespace

const char* StepOutcomeInWords(StepOutcome outcome) {
  switch (outcome) {
    case StepOutcome::kTaken:
      return "a step was taken";
    case StepOutcome::kSingular:
      return "a step's linear system is singular";
    case StepOutcome::kNoDescent:
      return "no step lowers the cost, however short: the start is too far off";
    case StepOutcome::kEquilibriumDiverged:
      return "the equilibrium of a loaded shot diverges";
  }
  return "";
}

StepOutcome DampedStep(const RowsAt& rows_at, const std::vector<int>& coordinates, ParameterSet* parameters) {
  if (coordinates.empty()) return StepOutcome::kTaken;
  const Linearization here = rows_at(*parameters, coordinates);
  if (!here.valid) return StepOutcome::kEquilibriumDiverged;
  const std::vector<int> moving = MovingColumns(here, *parameters);
  if (moving.empty()) return StepOutcome::kTaken;
  const Eigen::MatrixXd jacobian = here.jacobian(Eigen::all, moving);
  const double cost = here.residual.squaredNorm();
  for (const double damping : kDampings) {
    Eigen::VectorXd step;
    if (!SolveDamped(jacobian, here.residual, damping, &step)) return StepOutcome::kSingular;
    bool far = damping > 0.0 || (jacobian * step).squaredNorm() > kFarStep * cost;
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters->num_coordinates());
    for (size_t c = 0; c < moving.size(); ++c) {
      const int i = here.columns[moving[c]];
      const double to_bound = parameters->coordinates()[i].lower - parameters->Value(i);
      far |= step[c] < to_bound;
      delta[i] = std::max(step[c], to_bound);
    }
    ParameterSet trial = *parameters;
    trial.Plus(delta);
    if (far) {
      const Linearization there = rows_at(trial, coordinates);
      if (!there.valid || !(there.residual.squaredNorm() <= cost)) continue;
    }
    *parameters = trial;
    return StepOutcome::kTaken;
  }
  return StepOutcome::kNoDescent;
}

}  // namespace sagitta
