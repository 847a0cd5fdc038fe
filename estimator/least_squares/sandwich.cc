#include "estimator/least_squares/sandwich.h"

#include <algorithm>
#include <map>
#include <utility>

#include "estimator/least_squares/cluster_sandwich.h"
#include "estimator/least_squares/row_sums.h"
#include "estimator/least_squares/satterthwaite.h"
#include "problems/split.h"

namespace sagitta {
namespace {

// Beyond, clusters come eight side by side (cluster_sandwich.h), and degrees of freedom are of a sample.
constexpr size_t kMostClustersAlone = 2000;
constexpr size_t kScoreRowsAtOnce = 512;

std::vector<std::vector<int>> RowsOfClusters(const std::vector<int>& cluster_of) {
  std::map<int, std::vector<int>> rows;
  for (size_t k = 0; k < cluster_of.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) rows[cluster_of[k]].push_back(static_cast<int>(3 * k) + axis);
  }
  std::vector<std::vector<int>> list;
  for (auto& [cluster, own] : rows) list.push_back(std::move(own));
  return list;
}

// Rows of whole clusters at a time, by the same way as rows that are never held together.
RobustCovariance OfMany(const Linearization& linearization, const LinearSolution& solution,
                        const std::vector<int>& cluster_of) {
  constexpr int kClustersAtOnce = 256;
  const std::vector<std::vector<int>> clusters = RowsOfClusters(cluster_of);
  ClusterFit fit;
  fit.solution = solution;
  ClusterSandwich sandwich(linearization.num_columns(), static_cast<int>(clusters.size()), solution.covariance, {fit});
  std::vector<int> rows, own;
  const auto take = [&] {
    RowMajorMatrix both(static_cast<Eigen::Index>(rows.size()), linearization.num_columns() + 1);
    both << linearization.jacobian(rows, Eigen::all), linearization.residual(rows);
    sandwich.Add(both, own);
    rows.clear();
    own.clear();
  };
  for (size_t g = 0; g < clusters.size(); ++g) {
    rows.insert(rows.end(), clusters[g].begin(), clusters[g].end());
    own.insert(own.end(), clusters[g].size() / 3, static_cast<int>(g));
    if ((g + 1) % kClustersAtOnce == 0) take();
  }
  take();
  const int observed = static_cast<int>(3 * linearization.observations.size());
  return sandwich.Result(0, linearization.jacobian.bottomRows(linearization.num_rows() - observed));
}

}  // namespace

// With W W' = M and b_g = J_g W: s_g = J_g' A_g r_g = W^-T b_g' A_g r_g, and A_g J_g M = A_g b_g W'.
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
  if (clusters.size() > kMostClustersAlone) return OfMany(linearization, solution, cluster_of);
  const Eigen::MatrixXd& root = solution.covariance_root;
  Satterthwaite satterthwaite(n);
  Eigen::MatrixXd scores(n, clusters.size());
  for (size_t g = 0, next = 0; g < clusters.size(); g = next) {
    std::vector<int> rows;
    std::vector<Eigen::Index> first = {0};
    while (next < clusters.size() && (next == g || rows.size() < kScoreRowsAtOnce)) {
      rows.insert(rows.end(), clusters[next].begin(), clusters[next].end());
      first.push_back(static_cast<Eigen::Index>(rows.size()));
      ++next;
    }
    const Eigen::MatrixXd b = TallProduct(linearization.jacobian(rows, Eigen::all), root);
    const Eigen::MatrixXd unshrunk = satterthwaite.AddClusters(b, first, root.transpose());
    for (size_t i = g; i < next; ++i) {  // the score is (A_g b_g)' r_g
      const auto own = static_cast<Eigen::Index>(clusters[i].size());
      scores.col(static_cast<Eigen::Index>(i)) =
          unshrunk.middleRows(first[i - g], own).transpose() * linearization.residual(clusters[i]);
    }
  }
  const Eigen::MatrixXd priors = linearization.jacobian.bottomRows(linearization.num_rows() - observed);
  const Eigen::MatrixXd sampled = root * scores;
  const Eigen::MatrixXd stated = solution.covariance * priors.transpose();
  result.covariance = sampled * sampled.transpose() + stated * stated.transpose();
  const Eigen::VectorXd dof = satterthwaite.Degrees();
  for (int c = 0; c < n; ++c) {
    // A prior is exact: only the sampled part scatters, nu = 2 C^2 / var(C) = nu_sampled / share^2.
    const double share = sampled.row(c).squaredNorm() / std::max(1e-300, result.covariance(c, c));
    result.dof[c] = dof[c] / std::max(1e-12, share * share);
  }
  return result;
}

std::vector<int> ConfigurationClusters(const Measurements& data, const std::vector<int>& observations) {
  const std::vector<int> group_of = GroupsOfConfigurations(data);
  std::vector<int> cluster_of(group_of.size(), -1), clusters;  // the former of each group
  clusters.reserve(observations.size());
  int count = 0;
  for (const int i : observations) {
    int& cluster = cluster_of[group_of[static_cast<size_t>(data.shots[data.observations[i].shot].configuration)]];
    if (cluster < 0) cluster = count++;
    clusters.push_back(cluster);
  }
  return clusters;
}

}  // namespace sagitta
