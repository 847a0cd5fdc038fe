// Did something move for good while the points were measured: a station (or the robot's foot), a marker, the tool with
// all markers, the zero of a joint? In the order of measurement, with the columns D of what may have moved from one
// shot on,
//
//   gain = g' A^-1 g,    A = D'(I - H) D,   g = D'(I - H) r,   H = J (J'J)^-1 J'
//
// is what the step explains of the squared residuals r'(I - H) r given everything that is estimated, and given what may
// be off all the time: a constant error is no break. Nothing else in a calibration sees it: rows that are held out at
// random have moved like the others.
#pragma once

#include <optional>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

enum class BreakOf { kStation, kMarker, kTool, kJoint };

struct Break {
  BreakOf of = BreakOf::kStation;
  int index = -1;        // of the station, marker or joint; of the tool 0
  int last = -1;         // observation before it
  int first = -1;        // observation after it
  double share = 0.0;    // of the squared residuals that it explains
  double p_value = 1.0;  // with every place and every cause that was tried
  double moved = 0.0;    // RMS distance by which it moves the points after it, m
};

// The likeliest break of a judged estimate, where it is beyond chance (the experiment's significance) and beyond what
// the errors of an arm imitate.
std::optional<Break> FindBreak(const CalibrationProblem& problem, const Estimate& estimate);

}  // namespace sagitta
