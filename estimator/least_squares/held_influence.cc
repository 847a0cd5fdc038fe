#include "estimator/least_squares/held_influence.h"

#include <Eigen/Cholesky>

#include "estimator/least_squares/row_sums.h"

namespace sagitta {
namespace {

constexpr double kAboutTheArm = 1.0;  // m, rad

}  // namespace

std::vector<int> HeldCoordinates(const ParameterSet& parameters) {
  std::vector<int> held;
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    if (parameters.coordinates()[i].free && parameters.coordinates()[i].held) held.push_back(i);
  }
  return held;
}

double PhysicalRange(const Coordinate& coordinate) {
  if (coordinate.has_prior()) return coordinate.prior_sigma;
  const bool is_placed = coordinate.kind == CoordinateKind::kBase || coordinate.kind == CoordinateKind::kMarker;
  return is_placed ? kAboutTheArm : coordinate.hold_limit;
}

HeldInfluence FindHeldInfluence(const Linearization& both, const ParameterSet& parameters, int estimated,
                                double noise_scale) {
  HeldInfluence held;
  held.coordinates.assign(both.columns.begin() + estimated, both.columns.end());
  const auto n = static_cast<int>(held.coordinates.size());
  if (n > 0 && AreMany(both)) return FindHeldInfluence(Condense(SumRows(both)), parameters, estimated, noise_scale);
  held.slopes.setZero(estimated, n);
  held.second_moment.setZero(n, n);
  if (n == 0) return held;
  Linearization own = both;
  own.columns.resize(estimated);
  own.jacobian = both.jacobian.leftCols(estimated);
  const Eigen::MatrixXd jacobian = both.jacobian.rightCols(n);
  const Eigen::MatrixXd root = SolveLinearization(own).covariance_root;
  // G = -M J_e' J_h with M = W W'.
  held.slopes = -root * (root.transpose() * (own.jacobian.transpose() * jacobian));
  const Eigen::MatrixXd remaining = jacobian + own.jacobian * held.slopes;  // what no estimated one can imitate
  Eigen::VectorXd range(n);
  for (int i = 0; i < n; ++i) range[i] = PhysicalRange(parameters.coordinates()[held.coordinates[i]]);
  // I = P^-1 + remaining' remaining / scale^2, in units of the ranges: P = 1, and the inverse is well scaled.
  const Eigen::MatrixXd scaled = remaining * range.asDiagonal() / noise_scale;
  const Eigen::MatrixXd information = Eigen::MatrixXd::Identity(n, n) + scaled.transpose() * scaled;
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  const Eigen::VectorXd pull = factor.solve(Eigen::VectorXd(-scaled.transpose() * both.residual / noise_scale));
  // S = I^-1 + m m'.
  const Eigen::MatrixXd moment = factor.solve(Eigen::MatrixXd::Identity(n, n)) + pull * pull.transpose();
  held.second_moment = range.asDiagonal() * moment * range.asDiagonal();
  return held;
}

Eigen::MatrixXd AddedCovariance(const HeldInfluence& held) {
  return held.slopes * held.second_moment * held.slopes.transpose();
}

}  // namespace sagitta
