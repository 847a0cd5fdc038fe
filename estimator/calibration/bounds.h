// Values that rest on their physical bound where the data want them far beyond: not a small compliance but a
// contradiction.
#pragma once

#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {

constexpr double kFarBelow = 4.0;  // standard deviations: once in 30 000

// A coordinate on its lower bound.
struct BelowBound {
  int coordinate = -1;
  double sigmas = 0.0;  // standard deviations of noise by which the data want it below
};

// It stands where its bound is, or below.
bool RestsOnBound(const ParameterSet& parameters, int coordinate);

// Of the estimated coordinates those that move with the data: others rest on their bound.
std::vector<int> MovingColumns(const Estimate& estimate);

// By at least kFarBelow, in standard deviations of the noise that is left where the values may go below: what does not
// fit because they may not is no noise.
//
//   s = max(s_least, s_fit |r + J d| / |r|),   d the unbounded step
//
// fit: at `parameters`, as it was weighed; scale: s_fit, of its whitening sigmas; least: what they are at least, 1
// where they are stated, else 0.
std::vector<BelowBound> FindBelowBounds(const Linearization& fit, const ParameterSet& parameters, double scale,
                                        double least);

}  // namespace sagitta
