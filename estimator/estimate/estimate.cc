#include "estimator/estimate/estimate.h"

#include <cmath>
#include <map>

#include "problems/significance.h"

namespace sagitta {

NoiseReport::NoiseReport() = default;
NoiseReport::NoiseReport(const NoiseReport&) = default;
NoiseReport::NoiseReport(NoiseReport&&) noexcept = default;
NoiseReport& NoiseReport::operator=(const NoiseReport&) = default;
NoiseReport& NoiseReport::operator=(NoiseReport&&) noexcept = default;
NoiseReport::~NoiseReport() = default;

Estimate::Estimate() = default;
Estimate::Estimate(const Estimate&) = default;
Estimate::Estimate(Estimate&&) noexcept = default;
Estimate& Estimate::operator=(const Estimate&) = default;
Estimate& Estimate::operator=(Estimate&&) noexcept = default;
Estimate::~Estimate() = default;

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
    case Status::kNotRun:
      return "not_run";
  }
  return "no_convergence";
}

namespace {

// A caution is a factor of two or three (an expanded uncertainty, a maximum permissible error) in place of one.
constexpr double kVeryMuch = 10.0;

}  // namespace

double StatedTooLarge(const Estimate& estimate) {
  const SigmaReport& sigma = estimate.sigma;
  const bool is_compared = !sigma.IsOfResiduals() && estimate.dof > 0 && estimate.noise_report.components.empty();
  if (!is_compared || estimate.fit.rms < kBelowAnyInstrument || !(sigma.a_posteriori > 0.0)) return 1.0;
  const bool is_small = sigma.a_posteriori * kVeryMuch < 1.0 && 1.0 - sigma.p_value < kDefaultSignificance;
  return is_small ? 1.0 / sigma.a_posteriori : 1.0;
}

std::vector<Direction> LeftOpen(const Estimate& estimate) {
  const double too_large = StatedTooLarge(estimate);
  std::vector<Direction> open;
  for (const Direction& direction : estimate.identifiability.unidentifiable) {
    if (direction.sigma > too_large || too_large == 1.0) open.push_back(direction);
  }
  return open;
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

ResidualSize MeasureReadings(const Measurements& data, const std::vector<int>& observations,
                             const Eigen::Matrix3Xd& predicted) {
  Eigen::Matrix3Xd points(3, observations.size()), rotations(3, observations.size());
  long num_points = 0, num_rotations = 0;
  for (size_t k = 0; k < observations.size(); ++k) {
    const Observation& observation = data.observations[observations[k]];
    const Vector3<double> residual = MeasuredMinusPredicted(observation.reading(), predicted.col(k));
    if (observation.is_point()) {
      points.col(num_points++) = residual;
    } else {
      rotations.col(num_rotations++) = residual;
    }
  }
  ResidualSize size = MeasureResiduals(points.leftCols(num_points));
  const ResidualSize turned = MeasureResiduals(rotations.leftCols(num_rotations));
  size.rotations = turned.observations;
  size.rotation_rms = turned.rms;
  size.rotation_max = turned.distance_max;
  return size;
}

}  // namespace sagitta
