#include "estimator/least_squares/row_sums.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/least_squares/batch_algebra.h"
#include "models/batch/shot_program.h"

namespace sagitta {
namespace {

constexpr int kHeldRows = 48;        // that are summed together: they stay in the cache
constexpr double kFewEntries = 5e4;  // a QR factor of the rows costs a few milliseconds (docs/DECISIONS.md)
constexpr int kManyTimes = 4;  // rows per column: with fewer a QR factor of the rows costs little more than the sums

int InWholeLanes(int columns) { return (columns + kBatchLanes - 1) / kBatchLanes * kBatchLanes; }

}  // namespace

SumOfRows::SumOfRows(int numbers)
    : numbers_(numbers),
      columns_(InWholeLanes(numbers)),
      memory_(static_cast<std::size_t>(kHeldRows + columns_) * columns_ + kBatchLanes, 0.0),
      rows_(Aligned(memory_.data())),
      sums_(rows_ + static_cast<std::size_t>(kHeldRows) * columns_) {}

void SumOfRows::Clear() {
  held_ = 0;
  std::fill(sums_, sums_ + static_cast<std::size_t>(columns_) * columns_, 0.0);
}

double* SumOfRows::NextRow() {
  if (held_ == kHeldRows) Flush();
  return rows_ + static_cast<std::size_t>(held_++) * columns_;
}

void SumOfRows::Add(const double* row) { std::copy(row, row + numbers_, NextRow()); }

// Column by column, as these lie in memory, of as many rows as are summed together.
void SumOfRows::Add(const Linearization& from, const Eigen::VectorXd* root_weights) {
  Flush();
  const int n = from.num_columns();
  std::array<double, kHeldRows> weights;
  weights.fill(1.0);
  for (int first = 0; first < from.num_rows(); first += kHeldRows) {
    held_ = std::min(kHeldRows, from.num_rows() - first);
    if (root_weights != nullptr) std::copy_n(root_weights->data() + first, held_, weights.begin());
    for (int c = 0; c <= n; ++c) {
      const double* const column = (c < n ? from.jacobian.col(c).data() : from.residual.data()) + first;
      for (int r = 0; r < held_; ++r) rows_[static_cast<std::size_t>(r) * columns_ + c] = weights[r] * column[r];
    }
    Flush();
  }
}

void SumOfRows::Flush() {
  AddProducts(rows_, static_cast<std::size_t>(held_), static_cast<std::size_t>(columns_), sums_);
  held_ = 0;
}

Eigen::MatrixXd SumOfRows::Total() {
  Flush();
  const int n = numbers_;
  Eigen::MatrixXd total(n, n);
  for (int a = 0; a < n; ++a) {
    for (int b = a; b < n; ++b) total(a, b) = total(b, a) = sums_[static_cast<std::size_t>(a) * columns_ + b];
  }
  return total;
}

NormalSums SumRows(const Linearization& rows, const Eigen::VectorXd* root_weights) {
  SumOfRows sums(rows.num_columns() + 1);
  sums.Add(rows, root_weights);
  std::vector<int> columns = rows.columns;
  columns.resize(rows.num_columns(), -1);
  return {rows.valid, columns, sums.Total(), rows.num_rows()};
}

NormalSums SelectColumns(const NormalSums& sums, const std::vector<int>& columns) {
  NormalSums some{sums.valid, {}, {}, sums.rows};
  std::vector<int> kept = columns;
  for (const int c : columns) some.columns.push_back(sums.columns[c]);
  kept.push_back(sums.num_columns());
  some.matrix = sums.matrix(kept, kept);
  return some;
}

// J'J = P'L D L'P of columns of unit norm; R = D^1/2 L'P and R'c = J'r. A pivot that is round-off of the columns'
// unit norms is a direction that no row sees.
Linearization Condense(const NormalSums& sums) {
  const int n = sums.num_columns();
  Linearization rows;
  rows.columns = sums.columns;
  rows.valid = sums.valid;
  rows.jacobian.setZero(n + 1, n);
  rows.residual.setConstant(n + 1, std::nan(""));
  if (!sums.valid) return rows;
  const Eigen::VectorXd scale = sums.matrix.diagonal().head(n).cwiseSqrt().cwiseMax(1e-150);
  const Eigen::MatrixXd scaled =
      scale.cwiseInverse().asDiagonal() * sums.matrix.topLeftCorner(n, n) * scale.cwiseInverse().asDiagonal();
  const Eigen::VectorXd gradient = sums.matrix.col(n).head(n).cwiseQuotient(scale);
  const double round_off = 1e-15 * std::max(1, n);
  const Eigen::LDLT<Eigen::MatrixXd> factor(scaled);
  Eigen::VectorXd c = factor.transpositionsP() * gradient;
  factor.matrixL().solveInPlace(c);
  Eigen::VectorXd root(n);
  for (int i = 0; i < n; ++i) {
    const double pivot = factor.vectorD()[i];
    root[i] = pivot > round_off ? std::sqrt(pivot) : 0.0;
    c[i] = root[i] > 0.0 ? c[i] / root[i] : 0.0;
  }
  Eigen::MatrixXd lower = factor.matrixL();
  lower = lower * root.asDiagonal();
  lower = factor.transpositionsP().transpose() * lower;
  rows.jacobian.topRows(n) = lower.transpose() * scale.asDiagonal();
  rows.residual.head(n) = c;
  // What no step explains: r'r - r'J (J'J)^-1 J'r.
  rows.residual[n] = std::sqrt(std::max(0.0, sums.squared_residual() - c.squaredNorm()));
  return rows;
}

bool AreMany(double rows, double columns) { return rows * columns > kFewEntries && rows > kManyTimes * columns; }

Eigen::MatrixXd RootOf(const Eigen::MatrixXd& covariance) {
  if (covariance.size() == 0) return covariance;
  // C = D K D, K = V diag(l) V': R = D V diag(sqrt l). Of the correlations K, because units differ by 20 orders of
  // magnitude.
  const Eigen::VectorXd size = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::MatrixXd correlation = size.cwiseInverse().asDiagonal() * covariance * size.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  return size.asDiagonal() * eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

Eigen::MatrixXd TallProduct(const Eigen::MatrixXd& x, const Eigen::MatrixXd& w) {
  CHECK_EQ(x.cols(), w.rows());
  if (x.cols() == 0) return Eigen::MatrixXd::Zero(x.rows(), w.cols());  // no memory to point into
  Eigen::MatrixXd product(x.rows(), w.cols());
  MultiplyColumns(x.data(), x.rows(), x.rows(), x.cols(), w.data(), w.cols(), product.data());
  return product;
}

}  // namespace sagitta
