// Normal equations of everything that is fitted, summed in one pass without ever holding a row:
//
//   sum over units [J r]'[J r],    rows whitened, deviations of joints marginalised, priors and ties included
//
// Cost, gradient, Gauss-Newton step, covariance and rank follow from this one matrix of (columns + 1)^2 numbers. What
// takes rows (covariance, identifiability, bounded steps) is given as many rows as there are columns, with the same
// normal equations: `Condense`.
#pragma once

#include <vector>

#include "estimator/least_squares/row_batches.h"

namespace sagitta {

struct NormalSums {
  bool valid = false;        // false: the equilibrium of a loaded shot diverged
  std::vector<int> columns;  // coordinates, one per column
  Eigen::MatrixXd matrix;    // [J r]'[J r], SI, (columns + 1) x (columns + 1)
  int rows = 0;              // that were summed

  int num_columns() const { return static_cast<int>(columns.size()); }
  double squared_residual() const { return matrix(num_columns(), num_columns()); }
};

class NormalEquations {
 public:
  // The problem must outlive this; its observations stay as they are. The sums do not depend on the number of threads.
  NormalEquations(const CalibrationProblem& problem, const std::vector<int>& observations, const NoiseRoots& noise,
                  LatentTreatment treatment, int num_threads);

  const RowBatches& batches() const { return batches_; }

  // weights: how often each observation counts; empty: once. `with_priors`: and what the parameters' priors add.
  NormalSums Sum(const ParameterSet& parameters, const std::vector<int>& columns,
                 const std::vector<double>& weights = {}, bool with_priors = true) const;

 private:
  struct Block;

  RowBatches batches_;
  std::vector<Block> blocks_;  // pieces of work of fixed size, in a fixed order
  int num_threads_;
};

struct NormalEquations::Block {
  int group = 0, first = 0, last = 0;  // batches
};

// One row per column and one for what no step explains, so that J'J, J'r and r'r are those of the sums.
Linearization Condense(const NormalSums& sums);

// Rows of everything that is fitted, priors included: as they are while they are few, else condensed.
struct FittedRows {
  Linearization rows;
  int equations = 0;  // that the rows stand for
};
FittedRows RowsOf(const NormalEquations& equations, const ParameterSet& parameters, const std::vector<int>& columns);

}  // namespace sagitta
