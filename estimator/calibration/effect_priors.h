// Priors that a robot file states of its effects' parameters (EffectSpec::prior_sigmas): how large such an effect may
// be on this arm, whatever the noise of the rows is stated to be. Where rows scatter by s times what is stated, r is
// too large by s, and
//
//   min |r|^2 + sum_k (s v_k / P_k)^2
//
// weighs rows and priors as they are; the covariance, scaled by s^2, has P_k^2 of what no row sees.
#pragma once

#include "problems/parameter_set.h"

namespace sagitta {

bool AnyEffectPrior(const ParameterSet& parameters);
// Sets Coordinate::prior_sigma = P / s of these; true where it moves by more than a twentieth.
bool ScaleEffectPriors(double scale, ParameterSet* parameters);

}  // namespace sagitta
