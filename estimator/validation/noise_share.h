// How much of the errors on points that were not fitted is the noise of their own readings. With q^2 the mean squared
// error, n^2 that of the readings and nu the degrees of freedom of the errors (unseen.h),
//
//   q^2 = n^2 + r^2,    sd(q^2) = q^2 sqrt(2 / nu):
//
// r is what is left for the robot; where nothing but the residuals states the noise, what the model lacks is in n, and
// r is what parameters add. Where a diagnosis found the noise the two are not separated: n is what it left to the
// noise. Where r^2 is within the uncertainty of q^2 only a bound of it is known.
#pragma once

#include <vector>

#include "estimator/validation/unseen.h"

namespace sagitta {

struct NoiseShare {
  double noise = 0.0;          // m, RMS distance; 0: not known, or no considerable part
  double rest = 0.0;           // m, RMS distance
  bool rest_is_bound = false;  // 95 %, one-sided
  double rms_known_to = 0.0;   // share of the RMS, half a 95 % interval
  bool of_residuals = false;   // what the model lacks is in the noise
  // m, RMS distance: what is left of q^2 once the readings' noise as stated and what uncertain parameters add to it are
  // subtracted, where that is beyond its uncertainty; 0: the model is not known to lack anything. No prediction of a
  // point is better on average, whatever the covariance of the parameters says.
  double beyond_noise = 0.0;
};

// points: those of `unseen`.
NoiseShare ShareOfNoise(const Estimate& estimate, const std::vector<int>& points, const UnseenPoints& unseen);

// m, RMS distance: what errors on points that were not fitted are beyond the scatter of instrument and joints, on
// average, whether or not that is beyond chance; 0 where nothing is known.
double BeyondScatter(const UnseenPoints& unseen);
// The same beyond the scatter of the instrument alone, as stated where that is known.
double BeyondInstrument(const Estimate& estimate, const std::vector<int>& points, const UnseenPoints& unseen);

}  // namespace sagitta
