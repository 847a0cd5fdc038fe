#include "estimator/baselines/damped_step.h"

namespace sagitta {

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
