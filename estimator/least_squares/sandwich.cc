#include "estimator/least_squares/sandwich.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "estimator/least_squares/row_batches.h"
#include "estimator/least_squares/row_sums.h"

namespace sagitta {
namespace {

// 1 - h below this: the cluster alone determines a direction, its residual there
// is zero and says nothing (generalised inverse).
constexpr double kNoResidualLeft = 1e-9;
constexpr double kSmallLeverage = 0.02, kRoundOff = 1e-17;
// The products w_g . w_h are a small part of tr(P^2) where clusters are many (leverages are small): up to here all
// clusters are summed, beyond it those of more than twice the mean leverage and every second, third, .. of the others.
constexpr size_t kMostSampled = 2000;
constexpr size_t kRowsAtOnce = 512;

std::vector<std::vector<int>> RowsOfClusters(const std::vector<int>& cluster_of) {
  std::map<int, std::vector<int>> rows;
  for (size_t k = 0; k < cluster_of.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) rows[cluster_of[k]].push_back(static_cast<int>(3 * k) + axis);
  }
  std::vector<std::vector<int>> list;
  for (auto& [cluster, own] : rows) list.push_back(std::move(own));
  return list;
}

// A_g - I = (I - H)^-1/2 - 1 of H = b_g b_g': a small symmetric problem, of as many rows as the cluster has.
Eigen::MatrixXd Unshrinking(const Eigen::MatrixXd& h) {
  const double size = h.trace();  // no eigenvalue is larger
  if (size < kSmallLeverage) {    // 1/2 H + 1/2 3/4 H^2 + 1/2 3/4 5/6 H^3 + ..
    Eigen::MatrixXd power = 0.5 * h, sum = power;
    double left = size;
    for (int k = 2; left > kRoundOff; ++k, left *= size) {
      power = ((2.0 * k - 1.0) / (2.0 * k) * (power * h)).eval();
      sum += power;
    }
    return sum;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(h);
  Eigen::VectorXd gain(h.rows());
  for (int i = 0; i < gain.size(); ++i) {
    const double left = 1.0 - eigen.eigenvalues()[i];
    gain[i] = left > kNoResidualLeft ? 1.0 / std::sqrt(left) - 1.0 : -1.0;
  }
  return eigen.eigenvectors() * gain.asDiagonal() * eigen.eigenvectors().transpose();
}

// |w' w|^2, by the smaller of both products.
double SquaredProducts(const Eigen::MatrixXd& w) {
  const bool is_tall = w.rows() > w.cols();
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(std::min(w.rows(), w.cols()), std::min(w.rows(), w.cols()));
  if (is_tall) {
    product.selfadjointView<Eigen::Lower>().rankUpdate(w.transpose());
  } else {
    product.selfadjointView<Eigen::Lower>().rankUpdate(w);
  }
  return 2.0 * product.squaredNorm() - product.diagonal().squaredNorm();
}

// |sum w w'|^2 over vectors of n numbers, kBatchLanes of them in one row of lanes.
class VectorProducts {
 public:
  explicit VectorProducts(int n)
      : columns_((n + kGramBlock - 1) / kGramBlock * kGramBlock),
        sums_(columns_ / kGramBlock, columns_ / kGramBlock, true),
        lanes_(buffer_.Reserve(static_cast<std::size_t>(kRows) * columns_ * kBatchLanes)) {}

  template <typename Vector>
  void Add(const Vector& w) {
    double* const lane =
        lanes_ + static_cast<std::size_t>(held_ / kBatchLanes) * columns_ * kBatchLanes + held_ % kBatchLanes;
    for (int c = 0; c < w.size(); ++c) lane[c * kBatchLanes] = w[c];
    if (++held_ == kRows * kBatchLanes) Flush();
  }
  double SquaredNorm() {
    Flush();
    double sum = 0.0;
    for (int a = 0; a < columns_; ++a) {
      for (int b = a; b < columns_; ++b) sum += (a == b ? 1.0 : 2.0) * sums_.At(a, b) * sums_.At(a, b);
    }
    return sum;
  }

 private:
  static constexpr int kRows = 32;
  void Flush() {
    std::vector<const double*> rows;
    for (int i = 0; i * kBatchLanes < held_; ++i)
      rows.push_back(lanes_ + static_cast<std::size_t>(i) * columns_ * kBatchLanes);
    sums_.Add(rows, 0, 0);
    lanes_ = buffer_.Reserve(static_cast<std::size_t>(kRows) * columns_ * kBatchLanes);
    held_ = 0;
  }

  int columns_, held_ = 0;
  GramSums sums_;
  BatchBuffer buffer_;
  double* lanes_;
};

// Satterthwaite's degrees of freedom of each column's variance under independent noise: with a_g = A_g J_g M e and
// w_g = b_g' a_g, the variance is a quadratic form with P_gh = [g = h] |a_g|^2 - w_g . w_h; nu = tr(P)^2 / tr(P^2).
class Satterthwaite {
 public:
  Satterthwaite(int columns, size_t clusters)
      : step_((clusters + kMostSampled - 1) / kMostSampled),
        large_(2.0 * columns / static_cast<double>(clusters)),
        trace_(Eigen::ArrayXd::Zero(columns)),
        of_square_(Eigen::ArrayXd::Zero(columns)) {}

  // a: A_g J_g M, h: b_g b_g'.
  void Add(const Eigen::MatrixXd& b, const Eigen::MatrixXd& h, const Eigen::MatrixXd& a) {
    const Eigen::ArrayXd squares = a.colwise().squaredNorm().transpose().array();
    const Eigen::ArrayXd products = (h * a).cwiseProduct(a).colwise().sum().transpose().array();
    trace_ += squares - products;
    of_square_ += squares * (squares - 2.0 * products);
    const bool is_large = h.trace() > large_;
    if (!is_large && small_++ % step_ != 0) return;
    sample_.push_back({b, std::sqrt(is_large ? 1.0 : static_cast<double>(step_)) * a});
  }
  Eigen::VectorXd Degrees() const {
    Eigen::VectorXd dof(trace_.size());
    const auto n = static_cast<int>(dof.size());
    if (static_cast<int>(sample_.size()) < kFewTimes * n) return DegreesOfFew();
    for (int first = 0; first < n; first += kColumnsAtOnce) {
      const int count = std::min(kColumnsAtOnce, n - first);
      std::vector<std::unique_ptr<VectorProducts>> products;
      for (int i = 0; i < count; ++i) products.push_back(std::make_unique<VectorProducts>(n));
      for (const auto& [b, a] : sample_) {
        const Eigen::MatrixXd w = b.transpose() * a.middleCols(first, count);
        for (int i = 0; i < count; ++i) products[i]->Add(w.col(i));
      }
      for (int i = 0; i < count; ++i) {
        const int c = first + i;
        const double square = of_square_[c] + products[i]->SquaredNorm();
        dof[c] = square > 0.0 ? trace_[c] * trace_[c] / square : 1.0;
      }
    }
    return dof;
  }

 private:
  static constexpr int kColumnsAtOnce = 16, kFewTimes = 4;

  Eigen::VectorXd DegreesOfFew() const {
    Eigen::VectorXd dof(trace_.size());
    Eigen::MatrixXd w(dof.size(), sample_.size());
    for (int c = 0; c < dof.size(); ++c) {
      for (size_t g = 0; g < sample_.size(); ++g) {
        w.col(static_cast<Eigen::Index>(g)) = sample_[g].first.transpose() * sample_[g].second.col(c);
      }
      const double square = of_square_[c] + SquaredProducts(w);
      dof[c] = square > 0.0 ? trace_[c] * trace_[c] / square : 1.0;
    }
    return dof;
  }

  const size_t step_;
  const double large_;  // twice the mean leverage
  size_t small_ = 0;
  Eigen::ArrayXd trace_, of_square_;
  std::vector<std::pair<Eigen::MatrixXd, Eigen::MatrixXd>> sample_;  // b, a
};

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
  const Eigen::MatrixXd& root = solution.covariance_root;
  Satterthwaite satterthwaite(n, clusters.size());
  Eigen::MatrixXd scores(n, clusters.size());
  for (size_t g = 0, next = 0; g < clusters.size(); g = next) {
    std::vector<int> rows, first;
    while (next < clusters.size() && (next == g || rows.size() < kRowsAtOnce)) {
      first.push_back(static_cast<int>(rows.size()));
      rows.insert(rows.end(), clusters[next].begin(), clusters[next].end());
      ++next;
    }
    const Eigen::MatrixXd b = TallProduct(linearization.jacobian(rows, Eigen::all), root);
    Eigen::MatrixXd unshrunk = b;
    std::vector<Eigen::MatrixXd> h;
    for (size_t i = g; i < next; ++i) {
      const auto own = static_cast<Eigen::Index>(clusters[i].size());
      const auto own_b = b.middleRows(first[i - g], own);
      h.push_back(own_b * own_b.transpose());
      unshrunk.middleRows(first[i - g], own) += Unshrinking(h.back()) * own_b;
      scores.col(static_cast<Eigen::Index>(i)) =
          unshrunk.middleRows(first[i - g], own).transpose() * linearization.residual(clusters[i]);
    }
    const Eigen::MatrixXd a = TallProduct(unshrunk, root.transpose());
    for (size_t i = g; i < next; ++i) {
      const auto own = static_cast<Eigen::Index>(clusters[i].size());
      satterthwaite.Add(b.middleRows(first[i - g], own), h[i - g], a.middleRows(first[i - g], own));
    }
  }
  const Eigen::MatrixXd priors = linearization.jacobian.bottomRows(linearization.num_rows() - observed);
  const Eigen::MatrixXd sampled = root * scores;
  const Eigen::MatrixXd stated = solution.covariance * priors.transpose();
  result.covariance = sampled * sampled.transpose() + stated * stated.transpose();
  const Eigen::VectorXd dof = satterthwaite.Degrees();
  for (int c = 0; c < n; ++c) {
    const double share = sampled.row(c).squaredNorm() / std::max(1e-300, result.covariance(c, c));
    result.dof[c] = dof[c] / std::max(1e-12, share * share);
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
