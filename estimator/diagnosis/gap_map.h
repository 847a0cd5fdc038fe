// The gap for people to look at; nothing is chosen by it: how much of it each configuration, marker, joint, … has; per
// shot, what one joint would have to deviate; per visit, what an effect says and what the measurements ask for.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/explanations/drivers.h"

namespace sagitta {

// Where the misfit is: the share of one configuration, marker, joint, ….
struct WhereShare {
  std::string by;  // config, marker, axis, joint, load, station, time
  std::string key;
  double share = 0.0;  // of the excess chi-square
};
// Where the chi-square beyond the noise is; largest shares first. unstated_sigma: m, of rows that state no sigma: what
// all that was found leaves.
std::vector<WhereShare> FindWhere(const DiagnosedModel& model, double unstated_sigma);

// The gap in joint space: per shot, the deviation of one joint alone that would explain the residual best,
//
//   d = l' r / l' l,   r = whitened measured - predicted, l = how a deviation of the joint moves the rows,
//
// over what may drive it.
struct JointGap {
  std::string joint, unit;            // urad or um
  std::vector<int> shots;             // fitted ones that see the joint
  std::vector<double> before, after;  // deviation that the believed and the extended model lack, one per shot
  std::vector<Driver> over;           // its angle, torque, approach, time: those that vary
};
// One entry per joint that the measurements see.
std::vector<JointGap> MapGap(const DiagnosedModel& baseline, const DiagnosedModel& final);

// Measured against simulated over what drives an effect: per visit, the deviation of the effect's joint (or the size of
// the effect) that the measurements ask for, and what the effect says.
struct EffectView {
  std::string driver, driver_unit;  // horizontal: a joint's angle, time, temperature, configuration number
  std::string quantity, unit;       // vertical
  std::vector<double> x;            // one per visit
  std::vector<double> measured;     // what the model leaves where the effect is removed from it
  std::vector<double> simulated;    // what the effect says
};
// Of effects that a model has.
std::vector<EffectView> ViewEffects(const DiagnosedModel& with, const std::vector<EffectSpec>& specs);

}  // namespace sagitta
