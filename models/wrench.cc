#include "models/wrench.h"

namespace sagitta {

ForceOnTransform::ForceOnTransform(const Chain& chain, const ChainState<double>& state, int b)
    : chain_(chain), state_(state), b_(b), by_frame_(Eigen::MatrixXd::Zero(6, chain.num_transforms() + 1)) {}

void ForceOnTransform::AddForce(const WrenchInBase<double>& wrench, double times) {
  force_ += times * GeneralisedForce(chain_, state_, b_, wrench);
}

void ForceOnTransform::AddDerivative(const WrenchInBase<double>& wrench, bool turns_with_arm, double times) {
  if (b_ >= wrench.frame) return;
  const Vector3<double>& axis = state_.axis[b_];
  const Vector3<double> r = wrench.point - state_.origin[b_];
  const Vector3<double> h = wrench.force.cross(axis);
  auto sums = by_frame_.col(wrench.frame);
  if (!chain_.transforms[b_].is_rotation()) {
    before_ -= times * h;
    if (turns_with_arm) before_ += times * h, sums.head<3>() += times * h;
    return;
  }
  const Vector3<double> torque = r.cross(wrench.force) + wrench.moment;
  before_ += times * (axis.cross(torque) + axis.dot(r) * wrench.force - r.dot(wrench.force) * axis);
  sums.head<3>() += times * wrench.point.cross(h);
  sums.tail<3>() += times * h;
  if (!turns_with_arm) return;
  const Vector3<double> turned = r.dot(wrench.force) * axis - wrench.force.dot(axis) * r + wrench.moment.cross(axis);
  before_ += times * turned;
  sums.head<3>() += times * turned;
}

Eigen::RowVectorXd ForceOnTransform::ByValues() const {
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(chain_.num_transforms());
  Eigen::Matrix<double, 6, 1> beyond = Eigen::Matrix<double, 6, 1>::Zero();
  for (int a = chain_.num_transforms() - 1; a >= 0; --a) {
    beyond += by_frame_.col(a + 1);
    const Vector3<double>& axis = state_.axis[a];
    const Vector3<double> h = beyond.tail<3>();
    if (!chain_.transforms[a].is_rotation()) {
      if (a >= b_) row[a] = axis.dot(h);
    } else {
      row[a] = axis.dot(a < b_ ? before_ : Vector3<double>(beyond.head<3>() - state_.origin[a].cross(h)));
    }
  }
  return row;
}

}  // namespace sagitta
