// Rows of a matrix that may have no columns.
#pragma once

#include <Eigen/Core>

namespace sagitta {

// As middleRows; of a matrix without columns, whose data are nowhere, no place behind nowhere is computed (undefined
// behaviour, which sanitizers end a program for).
inline Eigen::MatrixXd RowBlock(const Eigen::MatrixXd& matrix, Eigen::Index first, Eigen::Index count) {
  if (matrix.cols() == 0) return Eigen::MatrixXd(count, 0);
  return matrix.middleRows(first, count);
}

}  // namespace sagitta
