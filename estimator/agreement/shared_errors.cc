#include "estimator/agreement/shared_errors.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <map>

#include "estimator/least_squares/normal_equations.h"

namespace sagitta {
namespace {

// Places of the points of each shot among the observations.
std::map<int, std::vector<size_t>> PointsOfShots(const CalibrationProblem& problem,
                                                 const std::vector<int>& observations) {
  std::map<int, std::vector<size_t>> places;
  for (size_t k = 0; k < observations.size(); ++k) {
    const Observation& row = problem.data().observations[observations[k]];
    if (row.is_point()) places[row.shot].push_back(k);
  }
  return places;
}

// What M, W and r come to, p x p.
struct SharedSums {
  double q = 0.0, square_of_w = 0.0;  // r'W r, tr W^2
  Eigen::MatrixXd g, g2;              // J'W J, J'W^2 J: W^2 = (m - 1) 1 + (m - 2) W in a shot of m points
};

SharedSums SumShots(const CalibrationProblem& problem, const Whole& whole) {
  const auto p = whole.rows.jacobian.cols();
  SharedSums sums{0.0, 0.0, Eigen::MatrixXd::Zero(p, p), Eigen::MatrixXd::Zero(p, p)};
  for (const auto& [shot, places] : PointsOfShots(problem, whole.observations)) {
    const auto m = static_cast<double>(places.size());
    if (places.size() < 2) continue;
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(3, p), own = Eigen::MatrixXd::Zero(p, p);
    Vector3<double> r = Vector3<double>::Zero();
    for (const size_t k : places) {
      const auto row = static_cast<Eigen::Index>(3 * k);
      const Vector3<double> error = whole.rows.residual.segment<3>(row);
      const Eigen::MatrixXd moved = whole.rows.jacobian.middleRows<3>(row);
      j += moved;
      r += error;
      own += moved.transpose() * moved;
      sums.q -= error.squaredNorm();
    }
    const Eigen::MatrixXd pairs = j.transpose() * j - own;
    sums.q += r.squaredNorm();
    sums.square_of_w += 3.0 * m * (m - 1.0);
    sums.g += pairs;
    sums.g2 += (m - 1.0) * own + (m - 2.0) * pairs;
  }
  return sums;
}

}  // namespace

double SharedErrors(const CalibrationProblem& problem, const Whole& whole) {
  if (!whole.are_held || !problem.latent.empty()) return 0.0;  // arrivals that share what is stated are whitened by it
  const SharedSums sums = SumShots(problem, whole);
  if (sums.square_of_w == 0.0) return 0.0;
  const Eigen::MatrixXd products = whole.rows.jacobian.transpose() * whole.rows.jacobian;
  const Linearization priors = PriorsOf(whole.estimate.parameters, whole.columns);
  const Eigen::LDLT<Eigen::MatrixXd> normal(products + priors.jacobian.transpose() * priors.jacobian);
  const Eigen::MatrixXd cg = normal.solve(sums.g);
  const double nu = static_cast<double>(whole.rows.residual.size()) - normal.solve(products).trace();
  if (!(nu >= 1.0) || !cg.allFinite()) return 0.0;
  const double variance = whole.rows.residual.squaredNorm() / nu, mean = -cg.trace();
  const double square = sums.square_of_w - 2.0 * normal.solve(sums.g2).trace() + (cg * cg).trace() - mean * mean / nu;
  return square > 0.0 && variance > 0.0 ? (sums.q / variance - mean) / std::sqrt(2.0 * square) : 0.0;
}

}  // namespace sagitta
