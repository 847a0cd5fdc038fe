#include "estimator/results/next_campaign.h"

#include <algorithm>

#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

// The joint's transform is `by` further on at the same reading of its encoder, rad or m. A compensator's spring keeps
// its own zero, as after a calibration.
void MoveZero(int joint, double by, Robot* robot) {
  const int transform = robot->chain.JointTransform(joint);
  ElementaryTransform& moved = robot->chain.transforms[transform];
  std::optional<GravityCompensator>& spring = robot->gravity_compensator;
  if (spring && spring->joint == joint && !spring->zero) spring->zero = moved.nominal;
  moved.nominal += moved.sign * by;
  if (!robot->dh) return;
  for (DhLink& link : robot->dh->links) {
    if (link.joint != joint) continue;
    (robot->chain.joints[joint].type == JointType::kRevolute ? link.theta : link.d) += moved.sign * by;
  }
}

}  // namespace

std::optional<Robot> RobotOfTheNextCampaign(const Robot& extended) {
  const auto goes = [&](const EffectSpec& spec) { return GoesWithTime(extended, spec); };
  if (std::none_of(extended.effects.begin(), extended.effects.end(), goes)) return std::nullopt;
  Robot next = extended;
  next.effects.clear();
  for (const EffectSpec& spec : extended.effects) {
    if (!goes(spec)) next.effects.push_back(spec);
    if (IsUseOf(JointSlip(), spec) && !spec.values.empty())
      MoveZero(next.chain.FindJoint(spec.target), spec.values.front(), &next);
  }
  return next;
}

}  // namespace sagitta
