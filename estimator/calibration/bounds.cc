#include "estimator/calibration/bounds.h"

#include <algorithm>
#include <cmath>

namespace sagitta {

bool RestsOnBound(const ParameterSet& parameters, int coordinate) {
  return parameters.Value(coordinate) <= parameters.coordinates()[coordinate].lower;
}

std::vector<int> MovingColumns(const Estimate& estimate) {
  std::vector<int> columns;
  for (const int i : estimate.estimated) {
    if (!RestsOnBound(estimate.parameters, i)) columns.push_back(i);
  }
  return columns;
}

std::vector<BelowBound> FindBelowBounds(const Linearization& fit, const ParameterSet& parameters, double scale,
                                        double least) {
  std::vector<int> resting;
  for (int c = 0; c < fit.num_columns(); ++c) {
    if (RestsOnBound(parameters, fit.columns[c])) resting.push_back(c);
  }
  if (resting.empty()) return {};
  const LinearSolution free = SolveLinearization(fit);
  if (!free.full_rank) return {};
  const double left = std::sqrt(free.residual_norm_squared / fit.residual.squaredNorm());
  const double noise = std::max(least, scale * left);
  std::vector<BelowBound> found;
  for (const int c : resting) {
    // d_c / sigma_c of the unbounded step: how far below the bound the data would go.
    const double below = -free.step[c] / (noise * std::sqrt(free.covariance(c, c)));
    if (below >= kFarBelow) found.push_back({fit.columns[c], below});
  }
  return found;
}

}  // namespace sagitta
