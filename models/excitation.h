// How strongly a shot excites each parameter of a model: what one unit of it turns (rad) or moves (m).
//
//   of a slot      joint effects and their kin: |factor|
//   by torque      |phi(tau)|, or what a wrench of its own does: |tau| times the slot's compliance
//   of a point     what reflectors, growth and instruments move: the largest among the markers
//
// The same number says when data determine a parameter (one standard deviation of it moves less than 5 mm or 5 mrad,
// FORMATS section 4) and how large it is on a machine of any size (EffectParameter::typical).
#pragma once

#include <vector>

#include "models/forward_model.h"

namespace sagitta {

// A torque of less lever than this, m, is the rounding of a force that passes through the axis.
constexpr double kNoLever = 1e-9;

// One number per parameter of the model, rad or m per SI unit; zeros where the load folds the arm. `shot` is prepared.
std::vector<double> MotionPerUnit(const ForwardModel& model, const ShotInput& shot, const double* theta,
                                  const Pose<double>& base_in_station, const std::vector<MarkerInFrame>& markers);

}  // namespace sagitta
