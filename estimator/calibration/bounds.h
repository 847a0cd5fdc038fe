// Values that rest on their physical bound where the data want them far beyond: not a small compliance but a
// contradiction.
#pragma once

#include <vector>

#include "estimator/least_squares/linearization.h"

namespace sagitta {

// A coordinate on its lower bound.
struct BelowBound {
  int coordinate = -1;
  double sigmas = 0.0;  // standard deviations of noise by which the data want it below
};

// By at least four standard deviations. fit: at `parameters`, as it was weighed; scale: of its whitening sigmas.
std::vector<BelowBound> FindBelowBounds(const Linearization& fit, const ParameterSet& parameters, double scale);

}  // namespace sagitta
