#include "estimator/least_squares/satterthwaite.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "estimator/least_squares/batch_algebra.h"
#include "estimator/least_squares/row_batches.h"

namespace sagitta {
namespace {

// 1 - h below this: the cluster alone determines a direction, its residual there
// is zero and says nothing (generalised inverse).
constexpr double kNoResidualLeft = 1e-9;
constexpr double kSmallLeverage = 0.02, kRoundOff = 1e-17;
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

}  // namespace

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
  // (1 - l)^-1/2 - 1 of every eigenvalue l; -1 takes its direction out of A.
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
  clusters_.emplace_back(b, weight == 1.0 ? a : Eigen::MatrixXd(std::sqrt(weight) * a));
}

Eigen::VectorXd Satterthwaite::Degrees() const {
  Eigen::VectorXd dof(trace_.size());
  const auto n = static_cast<int>(dof.size());
  if (static_cast<int>(clusters_.size()) < kFewTimes * n) return DegreesOfFew();
  for (int first = 0; first < n; first += kBlockColumns) {
    const int count = std::min(kBlockColumns, n - first);
    std::vector<std::unique_ptr<VectorProducts>> products;
    for (int i = 0; i < count; ++i) products.push_back(std::make_unique<VectorProducts>(n));
    for (const auto& [b, a] : clusters_) {
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

Eigen::VectorXd Satterthwaite::DegreesOfFew() const {
  Eigen::VectorXd dof(trace_.size());
  Eigen::MatrixXd w(dof.size(), clusters_.size());
  for (int c = 0; c < dof.size(); ++c) {
    for (size_t g = 0; g < clusters_.size(); ++g) {
      w.col(static_cast<Eigen::Index>(g)) = clusters_[g].first.transpose() * clusters_[g].second.col(c);
    }
    const double square = of_square_[c] + SquaredProducts(w);
    dof[c] = square > 0.0 ? trace_[c] * trace_[c] / square : 1.0;
  }
  return dof;
}

}  // namespace sagitta
