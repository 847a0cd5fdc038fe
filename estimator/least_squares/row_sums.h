// Sums in place of rows: cost, gradient, Gauss-Newton step, covariance and rank of a least-squares problem follow from
// the one matrix [J r]'[J r]. What accepts rows (covariance, identifiability, bounded steps) is given as many rows as
// there are columns, with the same sums: `Condense`.
#pragma once

#include <vector>

#include "estimator/least_squares/batch_algebra.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {

struct NormalSums {
  bool valid = false;        // false: the equilibrium of a loaded shot diverged
  std::vector<int> columns;  // coordinates, one per column
  Eigen::MatrixXd matrix;    // [J r]'[J r], SI, (columns + 1) x (columns + 1)
  int rows = 0;              // that were summed

  int num_columns() const { return static_cast<int>(columns.size()); }
  double squared_residual() const { return matrix(num_columns(), num_columns()); }
};

// Sums products of rows [J r], some dozen at a time in vector registers.
class SumOfRows {
 public:
  // numbers: of a row, residual included.
  explicit SumOfRows(int numbers);
  SumOfRows(SumOfRows&&) = default;  // not copied: it has memory of its own

  void Clear();
  // A row's numbers one after the other.
  void Add(const double* row);
  // All rows of a linearization, times their weights; null: once.
  void Add(const Linearization& from, const Eigen::VectorXd* root_weights);
  // Of the rows added since the last Clear.
  Eigen::MatrixXd Total();

 private:
  double* NextRow();
  void Flush();

  int numbers_, columns_;  // the latter a multiple of kBatchLanes; what is beyond the numbers stays zero
  int held_ = 0;           // rows that are not summed yet
  std::vector<double> memory_;
  double *rows_, *sums_;
};

// root_weights: of each row; null: once.
NormalSums SumRows(const Linearization& rows, const Eigen::VectorXd* root_weights = nullptr);
// What the sums say of some of their columns (positions).
NormalSums SelectColumns(const NormalSums& sums, const std::vector<int>& columns);

// One row per column and one for what no step explains, so that J'J, J'r and r'r are those of the sums.
Linearization Condense(const NormalSums& sums);

// A hundred configurations of three markers and 56 unknowns: below, the rows' own factors cost a few milliseconds, and
// keep the digits that squaring the condition number costs.
bool AreMany(double rows, double columns);
// Rows that are kept: 16 MB. More are looked at piece by piece (row_stream.h).
constexpr double kMostHeld = 2e6;
inline bool AreHeld(double rows, double columns) { return rows * columns <= kMostHeld; }
inline bool AreMany(const Linearization& rows) { return AreMany(rows.num_rows(), rows.num_columns()); }

// R with R R' = covariance; what is negative by round-off counts as zero.
Eigen::MatrixXd RootOf(const Eigen::MatrixXd& covariance);

// X W, fast where X is tall.
Eigen::MatrixXd TallProduct(const Eigen::MatrixXd& x, const Eigen::MatrixXd& w);

}  // namespace sagitta
