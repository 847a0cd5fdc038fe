// Parameters with their intervals and how well they are known, and which of them go hand in hand.
#pragma once

#include <vector>

#include "estimator/estimate/estimate.h"
#include "tools/report/picture.h"

namespace sagitta {

// Corrections with 95 % intervals, by kind and unit; the bar: how many times the standard uncertainty by that interval
// is below the limit that makes a parameter "weak" (1 mm, 1 mrad or half its value). Empty: nothing is estimated.
std::vector<Picture> KnownParameters(const Estimate& estimate);

// Correlations of the estimated parameters, the most correlated ones where they are many. Empty: fewer than two.
std::vector<Picture> Correlations(const Estimate& estimate);

}  // namespace sagitta
