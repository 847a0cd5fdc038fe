// The rows of a problem a few thousand at a time, for whatever looks at each of them once: no matrix of all rows is
// ever held, and what is looked at is still in the cache.
#pragma once

#include <functional>
#include <memory>
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
  // Where the point of an observation is predicted, m; root: S, its noise. S r = predicted - measured.
  Vector3<double> PredictedPoint(int i, const Observation& observation, const Matrix3<double>& root) const {
    return observation.point_in_station + root * rows.col(rows.cols() - 1).segment<3>(3 * i);
  }
};

// One thread's share of what is summed in one order: sums of their own numbers, which other shares leave alone.
struct Share {
  int number = 0, count = 1;

  bool Has(std::size_t sum) const { return static_cast<int>(sum % static_cast<std::size_t>(count)) == number; }
};

// Each on several threads at once, a piece on one of them: what it writes is of its piece alone.
using PieceVisit = std::function<void(const RowPiece& piece)>;
// Every share is called with every piece, in their order, each on a thread of its own.
using SharedVisit = std::function<void(const RowPiece& piece, const Share& share)>;

// Calls visit(piece) for every piece of batches that are at hand; positions in their list. False: equilibria diverge,
// and their pieces were left out.
bool ForEachPiece(const RowBatches& batches, const ParameterSet& parameters, const std::vector<int>& columns,
                  int num_threads, const PieceVisit& visit);

// Rows of listed observations, piece by piece.
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

  // Calls visit(piece) for every piece; on one thread, for piece after piece. False: equilibria diverge, and their
  // pieces were left out.
  bool ForEach(const ParameterSet& parameters, const std::vector<int>& columns, const PieceVisit& visit,
               int num_threads = 1) const;
  // The same in num_threads shares.
  bool ForEachShared(const ParameterSet& parameters, const std::vector<int>& columns, int num_threads,
                     const SharedVisit& visit) const;

 private:
  struct Maker;
  std::unique_ptr<RowBatches> BatchesOf(size_t piece) const;

  const CalibrationProblem& problem_;
  const std::vector<int> observations_;
  const Noise noise_;
  const LatentTreatment treatment_;
  std::vector<int> order_;      // positions, group by group
  std::vector<size_t> pieces_;  // where each begins in order_, and its end
};

// The rows that were fitted, as the fit weighs them, for everything that judges an estimate.
class FittedStream {
 public:
  // at_hand: those of the fit, or null: they are put side by side here, half a kB per shot. The problem must outlive
  // this, and its observations stay as they are.
  explicit FittedStream(const CalibrationProblem& problem, std::shared_ptr<const RowBatches> at_hand = nullptr,
                        int num_threads = 1);
  // The same rows with noise of one's own.
  FittedStream(const CalibrationProblem& problem, RowStream::Noise noise,
               std::shared_ptr<const RowBatches> at_hand = nullptr, int num_threads = 1);

  // The configuration of each observation, from 0 in the order in which they appear (sandwich.h).
  const std::vector<int>& clusters() const { return clusters_; }
  const std::vector<int>& observations() const { return batches_->observations(); }
  int num_threads() const { return num_threads_; }  // and shares

  // As those of a RowStream, in an order of their own; of the last, rows of one configuration are in one piece.
  bool ForEach(const ParameterSet& parameters, const std::vector<int>& columns, const PieceVisit& visit) const;
  bool ForEachShared(const ParameterSet& parameters, const std::vector<int>& columns, const SharedVisit& visit) const;
  bool ForEachOfClusters(const ParameterSet& parameters, const std::vector<int>& columns,
                         const SharedVisit& visit) const;

  // Calls visit(position, J d) for every observation, on several threads at once: what a step d, SI, of these columns
  // moves its rows by. step_of:
  // of an observation, the same for all of one shot (of one visit, where its deviations are marginalised).
  bool ForEachMoved(const ParameterSet& parameters, const std::vector<int>& columns,
                    const std::function<const Eigen::VectorXd&(int position)>& step_of,
                    const std::function<void(int position, const Vector3<double>& moved)>& visit) const;

  // PredictPoints (linearization.h) of the problem at other values, of listed observations in ascending order; of what
  // was fitted from the rows at hand.
  Eigen::Matrix3Xd Predict(const CalibrationProblem& problem, const ParameterSet& parameters,
                           const std::vector<int>& listed) const;

 private:
  const CalibrationProblem& problem_;
  const RowStream::Noise noise_;
  const std::vector<int> clusters_;
  std::shared_ptr<const RowBatches> batches_;
  const int num_threads_;
};

}  // namespace sagitta
