#include "estimator/noise/repeat_spread.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/least_squares/linearization.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

constexpr double kInfiniteVariance = 4.0;  // degrees of freedom of a denominator, and fewer
constexpr double kKnown = 1e9;             // degrees of freedom: as good as stated

// Variance of F(m, nu).
double VarianceOfF(double m, double nu) {
  return 2.0 * nu * nu * (m + nu - 2.0) / (m * (nu - 2.0) * (nu - 2.0) * (nu - 4.0));
}

std::vector<int> RotationsAmong(const CalibrationProblem& problem) {
  std::vector<int> rotations;
  for (const int i : problem.CalibrationObservations()) {
    if (!problem.data().observations[i].is_point()) rotations.push_back(i);
  }
  return rotations;
}

}  // namespace

RatioOfSpreads RatioByRepeats(const std::optional<RepeatScatter>& repeats, double m) {
  if (!repeats) return {1.0, std::numeric_limits<double>::infinity()};
  double mean = 0.0, variance = 0.0, share = 0.0, fewest = std::numeric_limits<double>::infinity();
  for (const KnownSpread& spread : SpreadsOf(*repeats)) {
    if (!(spread.share > 0.0)) continue;
    fewest = std::min(fewest, spread.dof);
    share += spread.share;
    if (spread.dof <= kInfiniteVariance) continue;
    mean += spread.share * spread.dof / (spread.dof - 2.0);
    variance += spread.share * spread.share * VarianceOfF(m * spread.share, spread.dof);
  }
  if (fewest <= kInfiniteVariance) return {1.0, fewest};
  const double rest = std::max(0.0, 1.0 - share);  // over a spread of its own: chi-square
  mean += rest;
  variance += rest > 0.0 ? 2.0 * rest / m : 0.0;
  const double r = variance / (mean * mean) * m;
  if (!(r > 2.0 * (1.0 + 1.0 / kKnown))) return {mean, std::numeric_limits<double>::infinity()};
  const double nu = (4.0 * r + 2.0 * m - 4.0) / (r - 2.0);
  return {mean * (nu - 2.0) / nu, nu};
}

double ChanceOfSquares(const std::optional<RepeatScatter>& repeats, double squares, double m) {
  const RatioOfSpreads ratio = RatioByRepeats(repeats, m);
  return FSurvival(squares / m / ratio.factor, m, ratio.dof);
}

double ChanceOfResiduals(const CalibrationProblem& problem, double squares, double m) {
  const std::optional<RepeatScatter>& repeats = problem.repeat_scatter;
  if (!repeats || !repeats->is_of_fitted || problem.noise_origin != NoiseOrigin::kRepeats) {
    return ChanceOfSquares(repeats, squares, m);
  }
  double within = 0.0;
  for (const KnownSpread& spread : SpreadsOf(*repeats)) within += spread.dof;
  if (!(m - within > 0.0)) return 1.0;
  return ChanceOfSquares(repeats, std::max(0.0, squares - within), m - within);
}

double DofOfSizes(const Vector3<double>& sigma, double dof_per_axis) {
  const double squares = sigma.squaredNorm();
  return dof_per_axis * squares * squares / sigma.cwiseAbs2().squaredNorm();
}

double DofOfSizes(const std::optional<RepeatScatter>& repeats) {
  return repeats ? DofOfSizes(repeats->sigma, repeats->dof) : std::numeric_limits<double>::infinity();
}

Eigen::VectorXd DofByRepeats(const CalibrationProblem& problem, const Estimate& estimate) {
  const RepeatScatter& repeats = *problem.repeat_scatter;
  const double of_points = 3.0 * repeats.dof, of_rotations = repeats.rotation_dof;
  const std::vector<int> rotations = RotationsAmong(problem);
  const Eigen::MatrixXd& c = estimate.model_covariance;
  Eigen::VectorXd dof = Eigen::VectorXd::Constant(c.rows(), of_points);
  if (rotations.empty() || !(repeats.rotation_sigma.minCoeff() > 0.0)) return dof;
  const Linearization own = Linearize(problem, estimate.parameters, rotations, estimate.estimated,
                                      ObservationNoise(problem, rotations, kFallbackSigma));
  const Eigen::VectorXd theirs = (own.jacobian * c).colwise().squaredNorm();
  for (Eigen::Index i = 0; i < dof.size(); ++i) {
    const double all = c(i, i), turned = std::min(theirs[i], all), rest = all - turned;
    dof[i] = all * all / (rest * rest / of_points + turned * turned / of_rotations);
  }
  return dof;
}

}  // namespace sagitta
