// Base poses along the base's own axes: what parts of the data are compared by does not depend on how the measurement
// frame lies.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "problems/parameter_set.h"

namespace sagitta {

class BaseTurns {
 public:
  // columns: coordinates behind the columns.
  BaseTurns(const ParameterSet& parameters, const std::vector<int>& columns);

  // Columns of a Jacobian; columns beyond the coordinates' stay.
  template <typename Matrix>
  void TurnColumns(Matrix* jacobian) const {
    for (const auto& [columns, rotation] : triples_) {
      (*jacobian)(Eigen::all, columns) = Eigen::MatrixXd((*jacobian)(Eigen::all, columns) * rotation);
    }
  }
  // The same of both sides of [J r]'[J r].
  void TurnSums(Eigen::MatrixXd* sums) const;
  // Of a covariance along the new axes: along those of the coordinates.
  Eigen::MatrixXd TurnBack(Eigen::MatrixXd covariance) const;
  // Of a covariance of the coordinates: its diagonal along the new axes.
  Eigen::VectorXd VariancesOf(const Eigen::MatrixXd& covariance) const;

 private:
  std::vector<std::pair<std::array<int, 3>, Matrix3<double>>> triples_;  // x, y, z of a translation or a rotation
};

}  // namespace sagitta
