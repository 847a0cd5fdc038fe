#include "estimator/baselines/damped_step.h"

namespace sagitta {

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
  Linearization here = rows_at(*parameters, coordinates).rows;
  if (!here.valid) return StepOutcome::kEquilibriumDiverged;
  std::vector<int> moving;
  here.columns.clear();
  for (int c = 0; c < here.num_columns(); ++c) {
    if (here.jacobian.col(c).isZero(0.0)) continue;
    moving.push_back(c);
    here.columns.push_back(coordinates[c]);
  }
  here.jacobian = here.jacobian(Eigen::all, moving).eval();
  return TakeOneStep(rows_at, here, parameters);
}

}  // namespace sagitta
