#include "estimator/least_squares/satterthwaite.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "estimator/least_squares/batch_algebra.h"
#include "estimator/least_squares/row_sums.h"

namespace sagitta {
namespace {

// 1 - h below this: the cluster alone determines a direction, its residual there
// is zero and says nothing (generalised inverse).
constexpr double kNoResidualLeft = 1e-9;
constexpr double kSmallLeverage = 0.02, kRoundOffOfSeries = 1e-17;  // below, ten terms: 0.02^10 = 1e-17
constexpr int kBlockColumns = 16, kFewTimes = 4;

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

}  // namespace

Eigen::MatrixXd Unshrinking(const Eigen::MatrixXd& h) {
  const double size = h.trace();  // no eigenvalue is larger
  if (size < kSmallLeverage) {    // 1/2 H + 1/2 3/4 H^2 + 1/2 3/4 5/6 H^3 + ..
    Eigen::MatrixXd power = 0.5 * h, sum = power;
    double left = size;
    for (int k = 2; left > kRoundOffOfSeries; ++k, left *= size) {
      power = ((2.0 * k - 1.0) / (2.0 * k) * (power * h)).eval();
      sum += power;
    }
    return sum;
  }
  // (1 - l)^-1/2 - 1 of every eigenvalue l; -1 removes its direction from A.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(h);
  Eigen::VectorXd gain(h.rows());
  for (int i = 0; i < gain.size(); ++i) {
    const double left = 1.0 - eigen.eigenvalues()[i];
    gain[i] = left > kNoResidualLeft ? 1.0 / std::sqrt(left) - 1.0 : -1.0;
  }
  return eigen.eigenvectors() * gain.asDiagonal() * eigen.eigenvectors().transpose();
}

void Satterthwaite::Add(const Eigen::MatrixXd& b, const Eigen::MatrixXd& h, const Eigen::MatrixXd& a, double weight) {
  // |a_g|^2 and |w_g|^2 = a_g' H a_g of every column.
  const Eigen::ArrayXd squares = a.colwise().squaredNorm().transpose().array();
  const Eigen::ArrayXd products = (h * a).cwiseProduct(a).colwise().sum().transpose().array();
  trace_ += weight * (squares - products);
  // tr(P^2) = sum_g |a_g|^2 (|a_g|^2 - 2 |w_g|^2) + sum_gh (w_g . w_h)^2: the first sum here, the second, |sum_g w_g
  // w_g'|^2, at the end.
  of_square_ += weight * squares * (squares - 2.0 * products);
  clusters_.emplace_back(b.transpose(), weight == 1.0 ? a : Eigen::MatrixXd(std::sqrt(weight) * a));
}

// A_g b_g = b_g + (A_g - 1) b_g.
Eigen::MatrixXd Satterthwaite::AddClusters(const Eigen::MatrixXd& b, const std::vector<Eigen::Index>& first,
                                           const Eigen::MatrixXd& root_of_listed, const std::vector<double>& weights) {
  const size_t clusters = first.size() - 1;
  Eigen::MatrixXd unshrunk = b;
  std::vector<Eigen::MatrixXd> h;
  for (size_t i = 0; i < clusters; ++i) {
    const auto own_b = b.middleRows(first[i], first[i + 1] - first[i]);
    h.push_back(own_b * own_b.transpose());
    unshrunk.middleRows(first[i], own_b.rows()) += Unshrinking(h.back()) * own_b;
  }
  const Eigen::MatrixXd a = TallProduct(unshrunk, root_of_listed);
  for (size_t i = 0; i < clusters; ++i) {
    const Eigen::Index own = first[i + 1] - first[i];
    Add(b.middleRows(first[i], own), h[i], a.middleRows(first[i], own), weights.empty() ? 1.0 : weights[i]);
  }
  return unshrunk;
}

Eigen::VectorXd Satterthwaite::Degrees() const {
  Eigen::VectorXd dof(trace_.size());
  const auto asked = static_cast<int>(dof.size());
  const int n = clusters_.empty() ? 0 : static_cast<int>(clusters_.front().first.rows());
  if (static_cast<int>(clusters_.size()) < kFewTimes * n) return DegreesOfFew();
  for (int first = 0; first < asked; first += kBlockColumns) {
    const int count = std::min(kBlockColumns, asked - first);
    std::vector<SumOfRows> products;
    for (int i = 0; i < count; ++i) products.emplace_back(n);
    Eigen::MatrixXd w(n, count);
    for (const auto& [b, a] : clusters_) {
      MultiplyColumns(b.data(), static_cast<std::size_t>(n), static_cast<std::size_t>(n),
                      static_cast<std::size_t>(b.cols()), a.col(first).data(), static_cast<std::size_t>(count),
                      w.data());
      for (int i = 0; i < count; ++i) products[static_cast<std::size_t>(i)].Add(w.col(i).data());
    }
    for (int i = 0; i < count; ++i) {
      const int c = first + i;
      const double square = of_square_[c] + products[static_cast<std::size_t>(i)].Total().squaredNorm();
      dof[c] = square > 0.0 ? trace_[c] * trace_[c] / square : 1.0;
    }
  }
  return dof;
}

Eigen::VectorXd Satterthwaite::DegreesOfFew() const {
  Eigen::VectorXd dof(trace_.size());
  const Eigen::Index n = clusters_.empty() ? 0 : clusters_.front().first.rows();
  Eigen::MatrixXd w(n, clusters_.size());
  for (int c = 0; c < dof.size(); ++c) {
    for (size_t g = 0; g < clusters_.size(); ++g) {
      w.col(static_cast<Eigen::Index>(g)) = clusters_[g].first * clusters_[g].second.col(c);
    }
    const double square = of_square_[c] + SquaredProducts(w);
    dof[c] = square > 0.0 ? trace_[c] * trace_[c] / square : 1.0;
  }
  return dof;
}

}  // namespace sagitta
