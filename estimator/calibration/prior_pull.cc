#include "estimator/calibration/prior_pull.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <vector>

#include "estimator/noise/repeat_spread.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

// Of the variance of a prior: rows that reduce it by no more than that cannot contradict it.
constexpr double kLeastRemoved = 1e-6;

// One direction of what priors state, in units of theirs: how far apart rows and prior are, and the variance of the
// rows.
struct Apart {
  double size = 0.0;
  double rows = 0.0;
};

// Priors x0 of variances P, rows that say x1 with variances D, both whitened by P: with the estimate x of variances V,
//
//   V^-1 = 1 + D^-1,   x - x0 = (1 - V) (x1 - x0),   eigenvalues: v = d / (1 + d),  1 - v = 1 / (1 + d).
std::vector<Apart> DirectionsApart(const CalibrationProblem& problem, const Linearization& fitted,
                                   const Estimate& estimate) {
  std::vector<Eigen::Index> stated;
  for (size_t k = 0; k < estimate.estimated.size(); ++k) {
    if (estimate.parameters.coordinates()[estimate.estimated[k]].has_stated_prior())
      stated.push_back(static_cast<Eigen::Index>(k));
  }
  if (stated.empty()) return {};
  const LinearSolution solution = SolveLinearization(fitted);
  if (!solution.full_rank) return {};
  const auto n = static_cast<Eigen::Index>(stated.size());
  Eigen::VectorXd sigma(n), away(n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const Eigen::Index k = stated[a];
    const int i = estimate.estimated[k];
    const Coordinate& coordinate = estimate.parameters.coordinates()[i];
    // A fit with weights of its own is not where the least of this chi-square is.
    const double step = problem.weight_roots.empty() ? 0.0 : solution.step[k];
    sigma[a] = coordinate.prior_sigma;
    away[a] = PriorResidual(coordinate, estimate.parameters.Value(i) + step);
  }
  const Eigen::MatrixXd left =
      sigma.cwiseInverse().asDiagonal() * solution.covariance(stated, stated) * sigma.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(left);
  const Eigen::VectorXd along = eigen.eigenvectors().transpose() * away;
  std::vector<Apart> directions;
  for (Eigen::Index a = 0; a < n; ++a) {
    const double removed = 1.0 - eigen.eigenvalues()[a];
    if (removed > kLeastRemoved) directions.push_back({along[a] / removed, 1.0 / removed - 1.0});
  }
  return directions;
}

// (x1 - x0)' (1 + s^2 D)^-1 (x1 - x0), s^2 = `variance`: chi-square of as many as there are; at s = 1 what the priors
// add to the least chi-square of all.
double SquaresApart(const std::vector<Apart>& directions, double variance) {
  double sum = 0.0;
  for (const Apart& apart : directions) sum += apart.size * apart.size / (1.0 + variance * apart.rows);
  return sum;
}

}  // namespace

void SetPriorsAside(const CalibrationProblem& problem, const Linearization& fitted, double* sum, double* dof,
                    Estimate* estimate) {
  PriorPull& pull = estimate->sigma.pull;
  pull = PriorPull();
  const std::vector<Apart> directions = DirectionsApart(problem, fitted, *estimate);
  pull.squares = SquaresApart(directions, 1.0);
  pull.priors = static_cast<int>(directions.size());
  const double own = *sum - pull.squares, freedom = *dof - pull.priors,
               significance = problem.experiment().significance;
  if (pull.priors == 0 || !(freedom > 0.0) || !(own > 0.0)) return;
  const bool stated = problem.sigma_is_stated();
  const bool is_known = stated && (own <= freedom || ChanceOfResiduals(problem, own, freedom) >= significance);
  const double variance = is_known ? 1.0 : own / freedom;
  const double noise_dof = is_known ? std::numeric_limits<double>::infinity() : freedom;
  pull.is_set_aside =
      FSurvival(SquaresApart(directions, variance) / pull.priors, pull.priors, noise_dof) < significance;
  if (!pull.is_set_aside) return;
  *sum = own;
  *dof = freedom;
}

}  // namespace sagitta
