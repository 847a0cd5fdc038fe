// What a data set can determine, before anything is estimated: lint of rows and robot file, and identifiability and
// leverage from one linearization at the aligned nominal robot (linear_state.h).
//
// The noise relative to which rank and weakness are decided is the larger of the stated sigmas and what a linear
// fit leaves: r + J x at the best x, one step, no iteration.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/inspection/data_lint.h"
#include "estimator/inspection/orientation.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/inspection/torque_lint.h"

namespace sagitta {

// Parameters whose estimates will go hand in hand.
struct CorrelationGroup {
  std::vector<std::string> names;
  double largest = 0.0;  // |correlation| of its closest pair
};

struct ConfigurationLeverage {
  int configuration = -1;
  double mean = 0.0;  // of the hat matrix's diagonal over its rows
  double most = 0.0;  // largest eigenvalue of its block: 1, what no other configuration checks
};

struct Inspection {
  std::vector<Finding> findings;  // serious ones first
  std::vector<MeasuredRange> joints;
  OrientationVariety orientation;
  ReadingLint reading;
  TorqueComparison torques;  // at the nominal robot, with the aligned base
  ResidualSize aligned;      // of the nominal robot, base and markers fitted, calibration rows
  struct RmsOfReadings {
    double point = 0.0;     // m per coordinate
    double rotation = 0.0;  // rad per axis; 0: no pose is read
  };
  RmsOfReadings linear;  // unweighted: what a linear fit leaves
  RmsOfReadings stated;  // sigmas; 0: none
  double scale = 1.0;    // of the stated sigmas, or of 1 mm, in everything below
  bool sigma_is_stated = false;
  bool sigma_differs = false;  // stated ones, between rows or axes: they weigh
  int unknowns = 0;
  Identifiability identifiability;
  std::vector<ParameterEstimate> parameters;  // asked for: expected sigma, identifiable, weak
  std::vector<CorrelationGroup> groups;
  std::vector<ConfigurationLeverage> leverage;  // highest first

  int Count(Severity severity) const;
};

Inspection Inspect(const CalibrationProblem& problem, const std::function<void(const std::string&)>& progress = {});

}  // namespace sagitta
