// Errors of a joint's own value: an angle where it turns, a length where it slides.
#pragma once

#include <string>

#include "models/effects/catalogue.h"

namespace sagitta {

// angle, length: sizes that machines show, rad and m.
inline EffectParameter JointError(const std::string& name, const Robot& robot, const EffectSpec& spec, double angle,
                                  double length) {
  const int joint = robot.chain.FindJoint(spec.target);
  const bool slides = joint >= 0 && robot.chain.joints[joint].type == JointType::kPrismatic;
  return {name, slides ? Quantity::kShift : Quantity::kSmallAngle, slides ? length : angle};
}

}  // namespace sagitta
