#include "estimator/agreement/between_parts.h"

namespace sagitta {

PartMoments::PartMoments(int coordinates)
    : whole_(Eigen::MatrixXd::Zero(coordinates, coordinates)),
      each_(Eigen::MatrixXd::Zero(coordinates, coordinates)),
      times_(Eigen::VectorXd::Zero(coordinates)) {}

void PartMoments::Add(const PartDifference& difference) {
  // d d' - C_a - C_b, of which the mean is 2 T.
  const Eigen::MatrixXd beyond = difference.value * difference.value.transpose() - difference.covariance;
  const std::vector<int>& at = difference.columns;
  each_(at, at) += beyond;
  times_(at).array() += 1.0;
  if (!difference.is_complete) return;
  whole_(at, at) += beyond;
  ++complete_;
}

void PartMoments::Add(const PartMoments& other) {
  whole_ += other.whole_;
  each_ += other.each_;
  times_ += other.times_;
  complete_ += other.complete_;
}

BetweenParts PartMoments::Result(const BaseTurns& turns) const {
  BetweenParts found;
  if (complete_ > 0) found.covariance = turns.TurnBack(whole_ / (2.0 * complete_));
  found.draws = times_;
  // A base pose's three are determined by the same splits: they turn together.
  found.variance = turns.TurnBack(each_).diagonal().cwiseMax(0.0).cwiseQuotient(2.0 * times_.cwiseMax(1.0));
  return found;
}

void TakeLarger(const BetweenParts& other, BetweenParts* found) {
  if (!found->known()) {
    *found = other;
    return;
  }
  for (Eigen::Index i = 0; i < found->variance.size(); ++i) {
    if (other.variance[i] <= found->variance[i]) continue;
    found->variance[i] = other.variance[i];
    found->draws[i] = other.draws[i];
  }
}

}  // namespace sagitta
