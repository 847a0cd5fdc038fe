// Whether the flange turns enough to separate where a marker sits on it from where the base stands.
#pragma once

#include <string>

#include "problems/calibration_problem.h"

namespace sagitta {

// How much a flange of this set of configurations turns: RMS displacement of the tip of a unit vector fixed in the
// flange about its mean, for the vector that moves least and the one that moves most (orthogonal to it). 0 and 0:
// constant orientation; 0 and more: it turns about one axis only.
struct OrientationVariety {
  double least = 0.0, most = 0.0;
  Vector3<double> still = Vector3<double>::UnitX();  // the one that moves least, flange frame
  std::string stations;                              // concerned, where there are others
};
// Stations that share no marker, directly or through others, are judged apart; this is the poorest of them.
OrientationVariety OrientationVarietyOf(const CalibrationProblem& problem);

}  // namespace sagitta
