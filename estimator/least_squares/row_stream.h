// The rows of a problem a few thousand at a time, for whatever looks at each of them once: no matrix of all rows is
// ever held, and what is looked at is still in the cache.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "estimator/least_squares/row_batches.h"

namespace sagitta {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Some observations, three rows each.
struct RowPiece {
  std::vector<int> positions;  // in the list of observations
  RowMajorMatrix rows;         // [J r]: whitened, SI; one column per column asked for, then the residual
  Eigen::MatrixXd latent;      // L of each row (linearization.h); no columns where joints are exact

  int num_observations() const { return static_cast<int>(positions.size()); }
};

class RowStream {
 public:
  // Noise roots of listed observations, m.
  using Noise = std::function<NoiseRoots(const std::vector<int>& observations)>;

  // together: the group of each observation; those of one group come in one piece, groups in the order in which they
  // appear. Empty: nothing but rows of one shot (of one visit, where its deviations are marginalised) go together. A
  // visit must not reach over two groups. The problem must outlive this, and its observations stay as they are.
  RowStream(const CalibrationProblem& problem, std::vector<int> observations, Noise noise, LatentTreatment treatment,
            const std::vector<int>& together = {});

  const std::vector<int>& observations() const { return observations_; }
  // What happens to the rows of each piece before they are seen.
  void ChangeRows(std::function<void(RowMajorMatrix*)> change) { change_ = std::move(change); }

  // Calls visit(piece) for piece after piece. False: an equilibrium diverges, and the rest was left out.
  bool ForEach(const ParameterSet& parameters, const std::vector<int>& columns,
               const std::function<void(const RowPiece& piece)>& visit) const;

 private:
  const CalibrationProblem& problem_;
  const std::vector<int> observations_;
  const Noise noise_;
  const LatentTreatment treatment_;
  std::function<void(RowMajorMatrix*)> change_;
  std::vector<int> order_;      // positions, group by group
  std::vector<size_t> pieces_;  // where each begins in order_, and its end
};

}  // namespace sagitta
