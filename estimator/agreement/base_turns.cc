#include "estimator/agreement/base_turns.h"

#include <algorithm>

namespace sagitta {

BaseTurns::BaseTurns(const ParameterSet& parameters, const std::vector<int>& columns) {
  std::vector<int> column_of(parameters.num_coordinates(), -1);
  for (size_t c = 0; c < columns.size(); ++c) column_of[columns[c]] = static_cast<int>(c);
  for (int s = 0; s < parameters.num_stations(); ++s) {
    const Matrix3<double> rotation = parameters.BaseInStation(s).rotation;
    for (const ParameterBlock* block : {&parameters.station_translation(s), &parameters.station_rotation(s)}) {
      std::array<int, 3> own;
      std::copy_n(column_of.begin() + block->first_coordinate, 3, own.begin());
      if (*std::min_element(own.begin(), own.end()) >= 0) triples_.emplace_back(own, rotation);
    }
  }
}

// J' = J R makes the coordinates R'x and their covariance R'CR.
Eigen::VectorXd BaseTurns::VariancesOf(const Eigen::MatrixXd& covariance) const {
  Eigen::VectorXd variances = covariance.diagonal();
  for (const auto& [columns, rotation] : triples_) {
    const Matrix3<double> turned = rotation.transpose() * covariance(columns, columns) * rotation;
    for (int axis = 0; axis < 3; ++axis) variances[columns[axis]] = turned(axis, axis);
  }
  return variances;
}

void BaseTurns::TurnSums(Eigen::MatrixXd* sums) const {
  for (int side = 0; side < 2; ++side) {
    TurnColumns(sums);
    sums->transposeInPlace();
  }
}

Eigen::MatrixXd BaseTurns::TurnBack(Eigen::MatrixXd covariance) const {
  for (const auto& [columns, rotation] : triples_) {
    covariance(columns, Eigen::all) = Eigen::MatrixXd(rotation * covariance(columns, Eigen::all));
    covariance(Eigen::all, columns) = Eigen::MatrixXd(covariance(Eigen::all, columns) * rotation.transpose());
  }
  return covariance;
}

}  // namespace sagitta
