#include "estimator/least_squares/sandwich.h"

#include <Eigen/SVD>
#include <cmath>
#include <map>

namespace sagitta {
namespace {

// 1 - h below this: the cluster alone determines a direction, its residual there
// is zero and says nothing (generalised inverse).
constexpr double kNoResidualLeft = 1e-9;

std::vector<std::vector<int>> RowsOfClusters(const std::vector<int>& cluster_of) {
  std::map<int, std::vector<int>> rows;
  for (size_t k = 0; k < cluster_of.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) rows[cluster_of[k]].push_back(static_cast<int>(3 * k) + axis);
  }
  std::vector<std::vector<int>> list;
  for (auto& [cluster, own] : rows) list.push_back(std::move(own));
  return list;
}

// A_g x for b = J_g M^1/2: I - H_gg = I - b b' has the eigenvectors of b's left
// singular vectors U, hence A_g = I + U diag((1 - s^2)^-1/2 - 1) U'.
Eigen::MatrixXd Unshrink(const Eigen::MatrixXd& b, const Eigen::MatrixXd& x) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(b, Eigen::ComputeThinU);
  Eigen::VectorXd gain(svd.singularValues().size());
  for (int i = 0; i < gain.size(); ++i) {
    const double left = 1.0 - svd.singularValues()[i] * svd.singularValues()[i];
    gain[i] = left > kNoResidualLeft ? 1.0 / std::sqrt(left) - 1.0 : -1.0;
  }
  return x + svd.matrixU() * (gain.asDiagonal() * (svd.matrixU().transpose() * x));
}

// Satterthwaite's degrees of freedom of one column's variance under independent
// noise. With a_g = A_g J_g M e and u_g = J_g' a_g, the variance is a quadratic
// form with P_gh = [g = h] |a_g|^2 - u_g' M u_h; nu = tr(P)^2 / tr(P^2).
double DegreesOfFreedom(const Eigen::VectorXd& squares, const Eigen::MatrixXd& w) {  // w: rows u_g' M^1/2
  const Eigen::VectorXd own = w.rowwise().squaredNorm();
  const double trace = squares.sum() - own.sum();
  const double of_square = squares.squaredNorm() - 2.0 * squares.dot(own) + (w.transpose() * w).squaredNorm();
  return of_square > 0.0 ? trace * trace / of_square : 1.0;
}

}  // namespace

RobustCovariance SandwichCovariance(const Linearization& linearization, const std::vector<int>& cluster_of) {
  const int n = linearization.num_columns();
  const int observed = static_cast<int>(3 * linearization.observations.size());
  const LinearSolution solution = SolveLinearization(linearization);
  const std::vector<std::vector<int>> clusters = RowsOfClusters(cluster_of);
  RobustCovariance result;
  result.clusters = static_cast<int>(clusters.size());
  result.covariance = solution.covariance;
  result.dof = Eigen::VectorXd::Constant(n, std::max(1, linearization.num_rows() - n));
  if (n == 0 || !solution.full_rank) return result;
  const Eigen::MatrixXd& m = solution.covariance;
  const Eigen::MatrixXd b = linearization.jacobian.topRows(observed) * solution.covariance_root;
  Eigen::MatrixXd a(observed, n);  // rows of A_g J_g M
  Eigen::MatrixXd scores(clusters.size(), n);
  for (size_t g = 0; g < clusters.size(); ++g) {
    const Eigen::MatrixXd j = linearization.jacobian(clusters[g], Eigen::all);
    Eigen::MatrixXd both(j.rows(), n + 1);
    both << j * m, linearization.residual(clusters[g]);
    const Eigen::MatrixXd unshrunk = Unshrink(b(clusters[g], Eigen::all), both);
    a(clusters[g], Eigen::all) = unshrunk.leftCols(n);
    scores.row(g) = (j.transpose() * unshrunk.col(n)).transpose();
  }
  const Eigen::MatrixXd priors = linearization.jacobian.bottomRows(linearization.num_rows() - observed);
  const Eigen::MatrixXd sampled = m * scores.transpose();
  const Eigen::MatrixXd stated = m * priors.transpose();
  result.covariance = sampled * sampled.transpose() + stated * stated.transpose();
  Eigen::VectorXd squares(clusters.size());
  Eigen::MatrixXd w(clusters.size(), n);
  for (int c = 0; c < n; ++c) {
    for (size_t g = 0; g < clusters.size(); ++g) {
      const Eigen::VectorXd own = a(clusters[g], c);
      squares[g] = own.squaredNorm();
      w.row(g) = own.transpose() * b(clusters[g], Eigen::all);
    }
    const double share = sampled.row(c).squaredNorm() / std::max(1e-300, result.covariance(c, c));
    result.dof[c] = DegreesOfFreedom(squares, w) / std::max(1e-12, share * share);
  }
  return result;
}

std::vector<int> ConfigurationClusters(const Measurements& data, const std::vector<int>& observations) {
  std::map<std::vector<double>, int> known;
  std::vector<int> clusters;
  clusters.reserve(observations.size());
  for (const int i : observations) {
    const Eigen::VectorXd& q = data.ConfigurationOf(data.observations[i]).q;
    const auto size = static_cast<int>(known.size());
    clusters.push_back(known.emplace(std::vector<double>(q.data(), q.data() + q.size()), size).first->second);
  }
  return clusters;
}

}  // namespace sagitta
