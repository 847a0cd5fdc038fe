// Distances before and after, whitened residuals: counts in bins.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/validation/unseen.h"
#include "problems/calibration_problem.h"
#include "tools/report/charts.h"
#include "tools/report/picture.h"

namespace sagitta {

// Of points that were not fitted, on one logarithmic axis. Empty: there are none, or they are met exactly.
std::vector<Picture> BeforeAndAfter(const UnseenPoints& before, const UnseenPoints& after);

// Counts in equal bins between the extremes of all, one row of bars per series.
Picture HistogramPicture(const std::string& title, const std::string& x_label, const std::vector<NamedSeries>& series);

// (measured - predicted) / sigma of calibration rows, per axis, next to the normal distribution.
Picture WhitenedHistogram(const CalibrationProblem& problem, const Estimate& estimate);

}  // namespace sagitta
