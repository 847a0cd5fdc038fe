#include "estimator/estimate/estimate.h"

#include <cmath>
#include <map>

namespace sagitta {

const char* StatusName(Status status) {
  switch (status) {
    case Status::kConverged:
      return "converged";
    case Status::kConvergedWithHeldParameters:
      return "converged_with_held_parameters";
    case Status::kNoConvergence:
      return "no_convergence";
    case Status::kSingular:
      return "singular";
    case Status::kEquilibriumDiverged:
      return "equilibrium_diverged";
  }
  return "no_convergence";
}

ResidualSize MeasureResiduals(const Eigen::Matrix3Xd& residuals) {
  ResidualSize size;
  size.observations = static_cast<int>(residuals.cols());
  if (residuals.cols() == 0) return size;
  const double n = static_cast<double>(residuals.cols());
  size.rms_axis = (residuals.rowwise().squaredNorm() / n).cwiseSqrt();
  size.rms = std::sqrt(residuals.squaredNorm() / (3.0 * n));
  size.max = residuals.cwiseAbs().maxCoeff();
  size.distance_rms = std::sqrt(residuals.squaredNorm() / n);
  size.distance_max = residuals.colwise().norm().maxCoeff();
  return size;
}

}  // namespace sagitta
