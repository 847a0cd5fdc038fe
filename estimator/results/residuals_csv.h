// residuals.csv and the rows of predict: the input rows in their order with all
// their columns, and more columns next to them.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"
#include "problems/io/output_files.h"

namespace sagitta {

struct AddedColumn {
  std::string name;
  // One per observation; those of points are written, one line each. As text or as numbers, of which what is not finite
  // is an empty cell.
  std::vector<std::string> cells;
  std::vector<double> numbers = {};
};

// A column that the rows already have is replaced where it stands. Several
// files: every column of any of them, in order of first appearance.
std::string RowsToCsv(const Measurements& data, const std::vector<AddedColumn>& added);
// The same piece by piece: the rows of a tracker stream are not held as text.
void RowsToCsv(const Measurements& data, const std::vector<AddedColumn>& added, const TextSink& write,
               int num_threads = 1);

// What was made of rows is handed over with these: std::invalid_argument, with the function's name, where there are
// more or fewer results than observations.
void CheckAreOf(const Measurements& rows, size_t results, const char* function);

// Readings of all observations (3 x N: points, m, and rotation vectors, rad) as columns <prefix>x_mm … and, where any
// row is a pose, <prefix>rx_mrad ….
std::vector<AddedColumn> ReadingColumns(const std::string& prefix, const Measurements& data,
                                        const Eigen::Matrix3Xd& readings);
// measured - predicted, res_x_mm ….
std::vector<AddedColumn> ResidualColumns(const Measurements& data, const Eigen::Matrix3Xd& predicted);

// measured - predicted over what one reading scatters by, whitened_x …; empty where that is zero.
std::vector<AddedColumn> WhitenedColumns(const Measurements& data, const Eigen::Matrix3Xd& predicted,
                                         const NoiseRoots& scatter);

// One per observation: the mean over all axes of its row, of a pose those of both readings.
std::vector<double> LeverageOfRows(const Measurements& data, const Estimate& estimate);

std::string ResidualsToCsv(const CalibrationProblem& problem, const Estimate& estimate);
void ResidualsToCsv(const CalibrationProblem& problem, const Estimate& estimate, const TextSink& write,
                    int num_threads = 1);
// residuals.csv, made while it is written; both must live until then.
LongText ResidualsFile(const CalibrationProblem& problem, const Estimate& estimate, int num_threads = 1);

// measured - predicted over its standard deviation, joint repeatability included, 3 x N: each row by itself (rows of
// one visit share what their joints did).
Eigen::Matrix3Xd WhitenedResiduals(const CalibrationProblem& problem, const Estimate& estimate);

}  // namespace sagitta
