// residuals.csv and the rows of predict: the input rows in their order with all
// their columns, and more columns beside them.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct AddedColumn {
  std::string name;
  std::vector<std::string> cells;  // one per observation
};

// A column that the rows already have is replaced where it stands. Several
// files: every column of any of them, in order of first appearance.
std::string RowsToCsv(const Measurements& data, const std::vector<AddedColumn>& added);

// `points` (3 x N, m) as columns <prefix>x_mm ….
std::vector<AddedColumn> PointColumns(const std::string& prefix, const Eigen::Matrix3Xd& points);

std::string ResidualsToCsv(const CalibrationProblem& problem, const Estimate& estimate);

// measured - predicted over its standard deviation, joint repeatability included, 3 x N: each row by itself (rows of
// one visit share what their joints did).
Eigen::Matrix3Xd WhitenedResiduals(const CalibrationProblem& problem, const Estimate& estimate);

}  // namespace sagitta
