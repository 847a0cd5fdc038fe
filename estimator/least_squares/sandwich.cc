#include "estimator/least_squares/sandwich.h"

#include "estimator/least_squares/batch_algebra.h"
#include "estimator/least_squares/row_batches.h"

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

// A_g - I for b = J_g M^1/2: I - H_gg = I - b b' has the eigenvectors U of b b', hence
// A_g = I + U diag((1 - lambda)^-1/2 - 1) U'. A small symmetric problem, of as many rows as the cluster has.
Eigen::MatrixXd Unshrinking(const Eigen::MatrixXd& b) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(b * b.transpose());
  Eigen::VectorXd gain(b.rows());
  for (int i = 0; i < gain.size(); ++i) {
    const double left = 1.0 - eigen.eigenvalues()[i];
    gain[i] = left > kNoResidualLeft ? 1.0 / std::sqrt(left) - 1.0 : -1.0;
  }
  return eigen.eigenvectors() * gain.asDiagonal() * eigen.eigenvectors().transpose();
}

// |w' w|^2 of rows that are filled in one by one, kBatchLanes of them in one row of lanes.
class RowProducts {
 public:
  RowProducts(int rows, int columns) : columns_((columns + kGramBlock - 1) / kGramBlock * kGramBlock) {
    const int blocks = columns_ / kGramBlock;
    sums_ = GramSums(blocks, blocks, true);
    const int lanes = (rows + kBatchLanes - 1) / kBatchLanes;
    memory_ = buffer_.Reserve(static_cast<size_t>(lanes) * columns_ * kBatchLanes);
    for (int i = 0; i < lanes; ++i) rows_.push_back(memory_ + static_cast<size_t>(i) * columns_ * kBatchLanes);
  }

  void Set(int row, const Eigen::VectorXd& values) {
    double* const lane = memory_ + static_cast<size_t>(row / kBatchLanes) * columns_ * kBatchLanes + row % kBatchLanes;
    for (int c = 0; c < values.size(); ++c) lane[c * kBatchLanes] = values[c];
  }
  double SquaredNorm() {
    sums_.Clear();
    sums_.Add(rows_, 0, 0);
    double sum = 0.0;
    for (int a = 0; a < columns_; ++a) {
      for (int b = a; b < columns_; ++b) sum += (a == b ? 1.0 : 2.0) * sums_.At(a, b) * sums_.At(a, b);
    }
    return sum;
  }

 private:
  int columns_;
  BatchBuffer buffer_;
  double* memory_;
  std::vector<const double*> rows_;
  GramSums sums_;
};

}  // namespace

// With W W' = M and b_g = J_g W: s_g = J_g' A_g r_g = W^-T b_g' A_g r_g, and A_g J_g M = A_g b_g W'. Satterthwaite's
// degrees of freedom of one column's variance under independent noise: with a_g = A_g J_g M e and w_g = b_g' a_g, the
// variance is a quadratic form with P_gh = [g = h] |a_g|^2 - w_g . w_h; nu = tr(P)^2 / tr(P^2).
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
  std::vector<int> order;  // rows, cluster by cluster
  for (const std::vector<int>& rows : clusters) order.insert(order.end(), rows.begin(), rows.end());
  const Eigen::MatrixXd& root = solution.covariance_root;
  const Eigen::MatrixXd b = linearization.jacobian(order, Eigen::all) * root;
  const Eigen::VectorXd residual = linearization.residual(order);
  Eigen::MatrixXd unshrunk(observed, n);  // A_g b_g
  Eigen::MatrixXd scores(n, clusters.size());
  std::vector<int> first(1, 0);
  for (size_t g = 0; g < clusters.size(); ++g) {
    const auto rows = static_cast<int>(clusters[g].size());
    const Eigen::MatrixXd own = b.middleRows(first.back(), rows);
    const Eigen::MatrixXd more = Unshrinking(own);
    unshrunk.middleRows(first.back(), rows) = own + more * own;
    scores.col(static_cast<int>(g)) =
        unshrunk.middleRows(first.back(), rows).transpose() * residual.segment(first.back(), rows);
    first.push_back(first.back() + rows);
  }
  const Eigen::MatrixXd priors = linearization.jacobian.bottomRows(linearization.num_rows() - observed);
  const Eigen::MatrixXd sampled = root * scores;
  const Eigen::MatrixXd stated = solution.covariance * priors.transpose();
  result.covariance = sampled * sampled.transpose() + stated * stated.transpose();
  const Eigen::MatrixXd a = unshrunk * root.transpose();
  RowProducts w(static_cast<int>(clusters.size()), n);
  for (int c = 0; c < n; ++c) {
    double trace = 0.0, of_square = 0.0;
    for (size_t g = 0; g < clusters.size(); ++g) {
      const auto rows = static_cast<int>(clusters[g].size());
      const Eigen::VectorXd own = b.middleRows(first[g], rows).transpose() * a.col(c).segment(first[g], rows);
      const double square = a.col(c).segment(first[g], rows).squaredNorm(), product = own.squaredNorm();
      trace += square - product;
      of_square += square * square - 2.0 * square * product;
      w.Set(static_cast<int>(g), own);
    }
    of_square += w.SquaredNorm();
    const double dof = of_square > 0.0 ? trace * trace / of_square : 1.0;
    const double share = sampled.row(c).squaredNorm() / std::max(1e-300, result.covariance(c, c));
    result.dof[c] = dof / std::max(1e-12, share * share);
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
