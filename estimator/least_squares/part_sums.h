// Sums of the rows of parts of the data, for many ways to divide them, from one pass.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "estimator/least_squares/row_stream.h"
#include "estimator/least_squares/row_sums.h"

namespace sagitta {

// One way to divide listed observations.
struct Partition {
  int parts = 0;
  std::vector<int> part_of;  // of each observation, from 0; -1: it is in none
};

// What is summed along where a pass over the fitted rows at an estimate is made anyway.
struct AlsoSummed {
  Partition partition;           // of what was fitted
  std::vector<NormalSums> sums;  // of its parts, without priors; empty: there was no such pass
};

// What comes out.
struct SummedParts {
  NormalSums all;
  std::vector<std::vector<NormalSums>> parts;  // of each partition, in the order in which these were given
};

// Sums what is added to every part of all partitions; observations that go together in some of these are summed once.
class PartSums {
 public:
  // columns: of the rows, in front of the residual.
  PartSums(std::size_t observations, const std::vector<int>& columns);
  ~PartSums();

  void Divide(const Partition& partition);
  // The three rows [J r] of an observation, one after the other, where the share has the sums that they belong to.
  void Add(int position, const double* rows, const Share& share = {});
  void Add(const RowPiece& piece, const Share& share);
  SummedParts Totals();

 private:
  class Cells;
  const std::size_t observations_;
  const NormalSums none_;
  std::vector<std::unique_ptr<Cells>> cells_;
};

}  // namespace sagitta
