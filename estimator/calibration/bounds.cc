#include "estimator/calibration/bounds.h"

#include <cmath>

namespace sagitta {
namespace {

constexpr double kFarBelow = 4.0;  // standard deviations: once in 30 000

}  // namespace

std::vector<BelowBound> FindBelowBounds(const Linearization& fit, const ParameterSet& parameters, double scale) {
  std::vector<int> resting;
  for (int c = 0; c < fit.num_columns(); ++c) {
    if (parameters.Value(fit.columns[c]) <= parameters.coordinates()[fit.columns[c]].lower) resting.push_back(c);
  }
  if (resting.empty()) return {};
  const LinearSolution free = SolveLinearization(fit);
  if (!free.full_rank) return {};
  std::vector<BelowBound> found;
  for (const int c : resting) {
    // d_c / sigma_c of the unbounded step: how far below the bound the data would go.
    const double below = -free.step[c] / (scale * std::sqrt(free.covariance(c, c)));
    if (below >= kFarBelow) found.push_back({fit.columns[c], below});
  }
  return found;
}

}  // namespace sagitta
