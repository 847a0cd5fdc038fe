#include "estimator/diagnosis/driver_functions.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>

namespace sagitta {

Eigen::MatrixXd Bumps(const Eigen::VectorXd& x, double low, double high, int count) {
  Eigen::MatrixXd bumps(x.size(), count);
  const double apart = (high - low) / (count - 1);
  for (int c = 0; c < count; ++c) {
    bumps.col(c) = (-0.5 * ((x.array() - (low + c * apart)) / apart).square()).exp();
  }
  // The sum over an endless row of squared bumps is sqrt(pi).
  return bumps / std::pow(3.14159265358979323846, 0.25);
}

Eigen::MatrixXd Waves(const Eigen::VectorXd& x, int orders) {
  Eigen::MatrixXd waves(x.size(), 2 * orders);
  for (int n = 1; n <= orders; ++n) {
    waves.col(2 * n - 2) = (n * x.array()).cos();
    waves.col(2 * n - 1) = (n * x.array()).sin();
  }
  return waves;
}

Eigen::MatrixXd Steps(const Eigen::VectorXd& x, const std::vector<double>& places) {
  Eigen::MatrixXd steps(x.size(), static_cast<long>(places.size()));
  for (size_t p = 0; p < places.size(); ++p) {
    steps.col(static_cast<long>(p)) = (x.array() > places[p]).cast<double>();
  }
  return steps;
}

std::vector<double> PlacesBetween(const Eigen::VectorXd& x, int most) {
  const std::set<double> distinct(x.data(), x.data() + x.size());
  const std::vector<double> sorted(distinct.begin(), distinct.end());
  std::vector<double> places;
  const size_t stride = sorted.size() / static_cast<size_t>(most) + 1;
  for (size_t i = stride; i < sorted.size(); i += stride) places.push_back(0.5 * (sorted[i - 1] + sorted[i]));
  return places;
}

// F = U S V', by the eigenvectors of the smaller of F'F and FF':  basis F V = U S, mixing V' = S^-1 U' F.
Compressed Compress(const Eigen::MatrixXd& functions, double tolerance) {
  const bool is_tall = functions.rows() >= functions.cols();
  const Eigen::MatrixXd gram =
      is_tall ? Eigen::MatrixXd(functions.transpose() * functions) : Eigen::MatrixXd(functions * functions.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  const double least = tolerance * tolerance * eigen.eigenvalues().maxCoeff();
  const long rank = (eigen.eigenvalues().array() > least).count();
  const Eigen::MatrixXd vectors = eigen.eigenvectors().rightCols(rank);
  if (is_tall) return {functions * vectors, vectors.transpose()};
  const Eigen::VectorXd sizes = eigen.eigenvalues().tail(rank).cwiseSqrt();
  return {vectors * sizes.asDiagonal(), sizes.cwiseInverse().asDiagonal() * (vectors.transpose() * functions)};
}

}  // namespace sagitta
