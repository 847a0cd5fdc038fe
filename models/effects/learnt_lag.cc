// A joint that follows late, with a first-order lag: the torque of what hangs on the arm (creep of a gear or a seat),
// or the heat that its own motion makes in its drive. It has no name.
#include <cmath>

#include "models/effects/catalogue.h"
#include "models/effects/first_order_lag.h"
#include "models/effects/learnt_deviation.h"
#include "models/kinematics.h"
#include "models/wrench.h"

namespace sagitta {
namespace {

using Kind = SettingDefinition::Kind;
using Campaign = std::vector<const ShotConditions*>;

bool IsBy(const EffectSpec& spec, const char* driver) { return spec.TextSetting("by", "load") == driver; }

// About the joint's positive direction in the nominal arm, N m (N where it slides): of the weight of the shot's own
// load, or, by weight, of 1 N at the flange.
double TorqueOn(const Chain& chain, const EffectSpec& spec, const ShotConditions& shot) {
  const Vector3<double> down = DownOf(spec).normalized();
  const std::vector<Pose<double>> frames = NominalFrames(chain, shot.q);
  const ElementaryTransform& transform = chain.transforms[chain.JointTransform(chain.FindJoint(spec.target))];
  const Pose<double>& here = frames[static_cast<size_t>(chain.JointTransform(chain.FindJoint(spec.target)))];
  const Vector3<double> axis = transform.sign * here.rotation.col(static_cast<int>(transform.axis));
  const auto torque_of = [&](const Vector3<double>& point, double weight) {
    const Vector3<double> force = weight * down, arm = point - here.translation;
    return axis.dot(transform.is_rotation() ? Vector3<double>(arm.cross(force)) : force);
  };
  if (!IsBy(spec, "load")) return torque_of(frames[static_cast<size_t>(chain.FlangeFrame())].translation, 1.0);
  double torque = 0.0;
  for (const AppliedWrench& wrench : shot.load_wrenches) {
    const bool is_in_gravity_frame = wrench.expressed_in == shot.gravity_frame;
    const double weight = is_in_gravity_frame ? wrench.force.dot(shot.gravity.normalized()) : wrench.force.norm();
    torque += torque_of(frames[static_cast<size_t>(wrench.frame)] * wrench.point, weight);
  }
  return torque;
}

std::vector<double> LaggedTorque(const Robot& robot, const EffectSpec& spec, const Campaign& campaign) {
  std::vector<double> time, torque;
  for (const ShotConditions* shot : campaign) {
    time.push_back(shot->time);
    torque.push_back(TorqueOn(robot.chain, spec, *shot));
  }
  return LaggedBehind(time, torque, spec.NumberSetting("lag_s", 1.0));
}

// dA/dt = (|dq/dt| - A) / tau, cold at the first shot, evenly fast between shots; what moves at once adds |dq| / tau.
std::vector<double> HeatOfMotion(const Robot& robot, const EffectSpec& spec, const Campaign& campaign) {
  const int joint = robot.chain.FindJoint(spec.target);
  const double tau = spec.NumberSetting("lag_s", 1.0);
  std::vector<double> heat;
  for (size_t i = 0; i < campaign.size(); ++i) {
    if (i == 0) {
      heat.push_back(0.0);
      continue;
    }
    const double way = std::abs(campaign[i]->q[joint] - campaign[i - 1]->q[joint]) / UnitOfJoint(robot, spec.target);
    const double dt = campaign[i]->time - campaign[i - 1]->time;
    const double share = dt > 0.0 ? -std::expm1(-dt / tau) * tau / dt : 1.0;
    heat.push_back(heat.back() * std::exp(-dt / tau) + way / tau * share);
  }
  return heat;
}

std::vector<double> Remember(const Robot& robot, const EffectSpec& spec, const Campaign& campaign) {
  std::vector<double> late =
      IsBy(spec, "motion") ? HeatOfMotion(robot, spec, campaign) : LaggedTorque(robot, spec, campaign);
  for (double& each : late) each /= spec.NumberSetting("unit", 1.0);
  return late;
}

std::vector<EffectParameter> Weight(const Robot& robot, const EffectSpec& spec) {
  return {WeightOfJoint(robot, spec, "w")};
}

void Deviate(const EffectContext& context, ShotTerms* terms) {
  terms->slots.push_back({context.joint_slot(), context.first_parameter, context.joint_sign() * context.memory});
}

std::string NoTime(const EffectContext& context) { return context.shot->has_time ? "" : "time_s"; }

}  // namespace

const EffectDefinition& LearntLag() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"learnt_lag", "learnt lag of a joint", "first-order lag", EffectTarget::kJoint, Weight,
                            Deviate};
    effect.settings.push_back({"by", Kind::kChoice, "", {"load", "weight", "motion"}});
    for (const char* name : {"down_x", "down_y", "down_z"}) {
      effect.settings.push_back({name, Kind::kNumber, "", {}});
      effect.settings.back().only_with = "by=load|weight";
    }
    for (const char* name : {"lag_s", "unit"}) {
      effect.settings.push_back({name, Kind::kNumber, "", {}});
      effect.settings.back().above = 0.0;
    }
    effect.on_slide = OnSlide::kDiagnosed;
    effect.missing = NoTime;
    effect.remember = Remember;
    return Empirical(std::move(effect));
  }();
  return definition;
}

}  // namespace sagitta
