// What may be wrong with the model, as a plan has to know it: measured robots err by more than noise, and a plan that
// does not know it trusts few extreme poses.
//
// Every revolute joint turns by an unknown smooth function of its own angle more than its encoder says, a random one:
//
//   delta_j(q) = sum_{k=1..4} c_k cos(k q) + s_k sin(k q),   c_k, s_k ~ N(0, a^2)
//
// a Gaussian process of standard deviation 2 a with covariance a^2 sum_k cos(k (q - q')), which has fallen to half
// within 30 deg. a is such that what a calibration with very many poses cannot absorb has the root mean square that
// the former estimate showed at points it had not fitted, beyond its prediction of them:
//
//   a^2 tr(H' (1 - P) H) / n = rms^2 - predicted^2
//
// H: columns of the field at n coordinates of the candidates, P: projection on the columns of everything else that is
// unknown. A plan then weighs noise and field together: readings near one another share the field's error.
#pragma once

#include <vector>

#include "estimator/planning/numbers.h"

namespace sagitta {

// Its effects, without those that the robot or `beside` has.
std::vector<EffectSpec> FieldEffects(const Robot& robot, const std::vector<EffectSpec>& beside);

// a, rad, for an excess of `rms`, m per coordinate. 0: everything else absorbs the field.
double FieldAmplitude(const PlanScene& scene, const std::vector<int>& columns, const std::vector<bool>& of_field,
                      double rms);

}  // namespace sagitta
