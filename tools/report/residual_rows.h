// The points of a report's pictures with what is left of them, mm, in the robot's base frame.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct ResidualRow {
  int observation = -1;
  Vector3<double> predicted_in_base, residual_in_base;  // mm; measured - predicted
  double distance() const { return residual_in_base.norm(); }
};

constexpr size_t kMostDrawn = 9000, kDrawnOfMany = 4000, kFarthestKept = 200;

// What a page draws of readings: where they were, and where a model sees them.
struct DrawnReadings {
  DrawnReadings(const CalibrationProblem& of, const ParameterSet& values, const Eigen::Matrix3Xd& points);
  DrawnReadings(const CalibrationProblem& of, const Estimate& estimate)
      : DrawnReadings(of, estimate.parameters, estimate.predicted) {}

  const CalibrationProblem& problem;
  const ParameterSet& parameters;     // base poses are read of these
  const Eigen::Matrix3Xd& predicted;  // m, in the station, a column per observation
  // Every point that is neither excluded nor without a measured value; of more than kMostDrawn kDrawnOfMany: the
  // farthest and an even choice of the others, in row order. Of so many, most lie on others: a picture is a thousand
  // pixels wide.
  const std::vector<ResidualRow> rows;
};

// "C12 P3", with its station where there are several.
std::string NameOfRow(const Measurements& data, const Observation& row);

// "; drawn: 4000 of 30000 points"; empty: all are.
std::string LeftOutInWords(const CalibrationProblem& problem, size_t drawn);

}  // namespace sagitta
