// Which rows no model of the robot gives: the rules by which a diagnosis sets readings aside (set_aside.h).
#pragma once

#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

struct OutlierLevel {
  double significance = 0.0;
  bool held_out = false;       // the model has not seen the rows
  bool given_effects = false;  // effects that were found are in it, and nothing without a name is left
  size_t removed = 0;          // rows, before
};

// Those of `observations` far outside the robust scatter (median) and alone so among the markers of their shot and
// body, or all of a shot that is off by far more than the others, the worst first: indices into
// Measurements::observations. None where so many points are off, those removed before counted, that it is something to
// explain. Of held-out rows what neither a rigid body nor all the other rows give away could as well be the model's
// error, and is no outlier.
std::vector<int> FindOutliers(const CalibrationProblem& problem, const ParameterSet& parameters,
                              const std::vector<int>& observations, const OutlierLevel& level);

// Fitted rows of the fewest configurations that have more than half of what all are off by beyond their scatter; none
// where these are more than outliers may be, or where chance makes them of so many configurations (significance). Such
// a few pull the fit so far that nothing is far off any more.
std::vector<int> RowsOfTheWorst(const CalibrationProblem& problem, const ParameterSet& parameters, double significance);

// Those of `outliers` (excluded from the fit) that this model predicts within the
// noise: they were none.
std::vector<int> ExplainedOutliers(const CalibrationProblem& problem, const ParameterSet& parameters,
                                   const std::vector<int>& outliers, double significance);

}  // namespace sagitta
