// The gap in joint space: per shot, the deviation of one joint alone that would explain the residual best,
//
//   d = l' r / l' l,   r = whitened measured - predicted, l = how a deviation of the joint moves the rows,
//
// over what may drive it. For people to look at: nothing is chosen by it.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"
#include "estimator/diagnosis/drivers.h"

namespace sagitta {

struct JointGap {
  std::string joint, unit;            // urad or um
  std::vector<int> shots;             // fitted ones that see the joint
  std::vector<double> before, after;  // deviation that the believed and the extended model lack, one per shot
  std::vector<Driver> over;           // its angle, torque, approach, time: those that vary
};

// One entry per joint that the measurements see.
std::vector<JointGap> MapGap(const DiagnosedModel& baseline, const DiagnosedModel& final);

}  // namespace sagitta
