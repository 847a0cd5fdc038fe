// Sums in place of rows: cost, gradient, Gauss-Newton step, covariance and rank of a least-squares problem follow from
// the one matrix [J r]'[J r]. What takes rows (covariance, identifiability, bounded steps) is given as many rows as
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

// Sums rows of one linearization, eight at a time in vector registers.
class RowSums {
 public:
  explicit RowSums(const Linearization& from);

  void Clear();
  // root_weights: of each row of the linearization; null: 1.
  void Add(int row, const Eigen::VectorXd* root_weights = nullptr);
  // Of the rows added since the last Clear.
  Eigen::MatrixXd Total();

 private:
  void Flush();

  const Linearization& from_;
  int columns_;  // residual included, a multiple of kGramBlock
  int held_ = 0;
  std::vector<double> memory_;
  double* rows_;
  GramSums sums_;
};

NormalSums SumRows(const Linearization& rows, const Eigen::VectorXd* root_weights = nullptr);
// What the sums say of some of their columns (positions).
NormalSums SelectColumns(const NormalSums& sums, const std::vector<int>& columns);

// One row per column and one for what no step explains, so that J'J, J'r and r'r are those of the sums.
Linearization Condense(const NormalSums& sums);

// A hundred configurations of three markers and 56 unknowns: below, the rows' own factors cost a few milliseconds, and
// keep the digits that squaring the condition number takes.
bool AreMany(double rows, double columns);
inline bool AreMany(const Linearization& rows) { return AreMany(rows.num_rows(), rows.num_columns()); }

// R with R R' = covariance; what is negative by round-off counts as zero.
Eigen::MatrixXd RootOf(const Eigen::MatrixXd& covariance);

// X W, fast where X is tall.
Eigen::MatrixXd TallProduct(const Eigen::MatrixXd& x, const Eigen::MatrixXd& w);

}  // namespace sagitta
