// Normal equations of everything that is fitted, summed in one pass without ever holding a row:
//
//   sum over units [J r]'[J r],    rows whitened, deviations of joints marginalised, priors and ties included
//
#pragma once

#include <memory>
#include <vector>

#include "estimator/least_squares/row_batches.h"
#include "estimator/least_squares/row_stream.h"
#include "estimator/least_squares/row_sums.h"

namespace sagitta {

class NormalEquations {
 public:
  // What the problem was given must outlive this; its observations stay as they are. The sums do not depend on the
  // number of threads.
  NormalEquations(const CalibrationProblem& problem, const std::vector<int>& observations, const NoiseRoots& noise,
                  LatentTreatment treatment, int num_threads);
  ~NormalEquations();

  int num_threads() const { return num_threads_; }
  const RowBatches& batches() const { return *batches_; }
  int num_passes() const;  // over the rows, so far
  const std::shared_ptr<const RowBatches>& shared_batches() const { return batches_; }

  // weights: how often each observation counts; empty: once. `with_priors`: and what the parameters' priors add. The
  // latest sums without weights are kept: a solver asks for the cost and then for the derivatives of the same values,
  // and what is held, and how far the optimum is, are asked of it once more.
  NormalSums Sum(const ParameterSet& parameters, const std::vector<int>& columns,
                 const std::vector<double>& weights = {}, bool with_priors = true) const;
  // After a step, SI, too small for J to change: what is kept of where it began is kept as the sums of where it ended,
  // r + J step in place of r, so that no pass is made there.
  void KeepMoved(const ParameterSet& from, const std::vector<int>& columns, const Eigen::VectorXd& step,
                 const ParameterSet& to) const;

 private:
  struct Block;
  struct Latest;

  NormalSums SumOfAll(const ParameterSet& parameters, const std::vector<int>& columns,
                      const std::vector<double>& weights) const;

  std::shared_ptr<const RowBatches> batches_;
  std::vector<Block> blocks_;  // pieces of work of fixed size, in a fixed order
  int num_threads_;
  std::unique_ptr<Latest> latest_;
};

struct NormalEquations::Block {
  int group = 0, first = 0, last = 0;  // batches
};

// Rows of everything that is fitted, priors included: as they are while they are few, else condensed.
struct FittedRows {
  Linearization rows;
  int equations = 0;  // that the rows stand for
};
FittedRows RowsOf(const NormalEquations& equations, const ParameterSet& parameters, const std::vector<int>& columns);

// The same where rows are asked for once. Those that are kept, AreHeld, are in the order of their observations.
FittedRows FittedOnce(const CalibrationProblem& problem, const ParameterSet& parameters,
                      const std::vector<int>& observations, const std::vector<int>& columns,
                      const RowStream::Noise& noise);
// Of rows without priors.
NormalSums SumRows(const RowStream& stream, const ParameterSet& parameters, const std::vector<int>& columns);
// Rows of priors and ties.
Linearization PriorsOf(const ParameterSet& parameters, const std::vector<int>& columns);

}  // namespace sagitta
