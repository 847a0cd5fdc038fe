#include "estimator/agreement/between_parts.h"

namespace sagitta {

PartMoments::PartMoments(int coordinates)
    : sums_(Eigen::MatrixXd::Zero(coordinates, coordinates)),
      pairs_(Eigen::MatrixXd::Zero(coordinates, coordinates)),
      times_(Eigen::VectorXd::Zero(coordinates)) {}

void PartMoments::Add(const PartDifference& difference) {
  // d d' - C_a - C_b, of which the mean is 2 T.
  const std::vector<int>& at = difference.columns;
  sums_(at, at) += difference.value * difference.value.transpose() - difference.covariance;
  times_(at).array() += 1.0;
  Eigen::VectorXd compared = Eigen::VectorXd::Ones(times_.size());
  compared(difference.one_sided).setZero();
  pairs_ += compared * compared.transpose();
}

void PartMoments::Add(const PartMoments& other) {
  sums_ += other.sums_;
  pairs_ += other.pairs_;
  times_ += other.times_;
}

BetweenParts PartMoments::Result(const BaseTurns& turns) const {
  BetweenParts found;
  found.covariance = turns.TurnBack(sums_.cwiseQuotient(2.0 * pairs_.cwiseMax(1.0)));
  found.draws = times_;
  // A base pose's three are determined by the same splits: they turn together.
  found.variance = turns.TurnBack(sums_).diagonal().cwiseMax(0.0).cwiseQuotient(2.0 * times_.cwiseMax(1.0));
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
