// What one unit of an explanation is: the size that its effect typically has on a machine.
#pragma once

#include <vector>

#include "models/effects/effect.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// m or rad where the rows excite it most, of an own effect that states none: as of geometric errors
// (frozen_geometry.cc).
constexpr double kTypicalMotion = 3e-4;

// Of one effect's parameters, SI. motions: what one SI unit of each turns (rad) or moves (m) where the rows excite it
// most; most_of_targets: of an effect that has one size on all of them (EffectDefinition::one_size), the most there.
std::vector<double> TypicalSizes(const std::vector<EffectParameter>& of_effect, const std::vector<double>& motions,
                                 double most_of_targets = 0.0);

// Stated by these effects' definitions (EffectParameter::typical), SI, one per coordinate of `parameters`; of those
// that are stated as a motion, what makes this motion where the rows excite it most; one unit for all of an effect,
// that of the most excited, of one that has one size on all targets among those listed (ku and kv; first moments in kg
// m and the mass in kg, as of links whose centre is a metre from the joint). 0: no parameter of one of them, or one
// that no row excites.
std::vector<double> TypicalSizes(const CalibrationProblem& problem, const ParameterSet& parameters,
                                 const std::vector<EffectSpec>& effects);

}  // namespace sagitta
