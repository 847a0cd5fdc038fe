// Deviations of a joint that have no name and no width: a wave over another joint's angle, a jump at a place. As
// learnt_deviation.cc, but a sum of bumps would follow neither between its knots nor where no pose was measured.
#include <algorithm>
#include <cmath>

#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "models/effects/learnt_deviation.h"

namespace sagitta {
namespace {

using Kind = SettingDefinition::Kind;

int Driver(const Robot& robot, const EffectSpec& spec) { return robot.chain.FindJoint(spec.TextSetting("driver", "")); }

bool Slides(const Robot& robot, int joint) {
  return joint >= 0 && robot.chain.joints[static_cast<size_t>(joint)].type == JointType::kPrismatic;
}

EffectParameter WeightOf(const Robot& robot, const EffectSpec& spec, const char* name) {
  if (Slides(robot, robot.chain.FindJoint(spec.target))) return {name, Quantity::kShift, kTypicalTravel};
  return {name, Quantity::kSmallAngle, kTypicalTurn};
}

std::vector<EffectParameter> WaveWeights(const Robot& robot, const EffectSpec& spec) {
  return {WeightOf(robot, spec, "cos"), WeightOf(robot, spec, "sin")};
}

// Encoder side: cos cos(n q_driver) + sin sin(n q_driver).
void DeviateByWave(const EffectContext& context, ShotTerms* terms) {
  const double phase =
      context.spec->IntegerSetting("order", 1) * context.shot->q[Driver(*context.robot, *context.spec)];
  const double sign = context.joint_sign();
  terms->slots.push_back({context.joint_slot(), context.first_parameter, sign * std::cos(phase)});
  terms->slots.push_back({context.joint_slot(), context.first_parameter + 1, sign * std::sin(phase)});
}

std::vector<EffectParameter> JumpWeight(const Robot& robot, const EffectSpec& spec) {
  return {WeightOf(robot, spec, "jump")};
}

// Encoder side: the jump beyond `to`, nothing before `from`, and evenly more between them, where it lies somewhere.
void DeviateByJump(const EffectContext& context, ShotTerms* terms) {
  const int driver = Driver(*context.robot, *context.spec);
  const double unit = Slides(*context.robot, driver) ? 1e-3 : kDegree;
  const double from = unit * context.spec->NumberSetting("from", 0.0),
               to = unit * context.spec->NumberSetting("to", 1.0);
  const double share = std::clamp((context.shot->q[driver] - from) / (to - from), 0.0, 1.0);
  terms->slots.push_back({context.joint_slot(), context.first_parameter, share * context.joint_sign()});
}

EffectDefinition OfJoint(EffectDefinition effect, const std::vector<SettingDefinition>& settings) {
  effect.settings = {{"driver", Kind::kJoint, "", {}}};
  effect.settings.insert(effect.settings.end(), settings.begin(), settings.end());
  effect.on_prismatic = true;
  return Empirical(std::move(effect));
}

}  // namespace

const EffectDefinition& LearntWaveDeviation() {
  static const EffectDefinition definition =
      OfJoint({"learnt_wave_deviation", "learnt wave of a joint", "wave over a joint's angle", EffectTarget::kJoint,
               WaveWeights, DeviateByWave},
              {{"order", Kind::kInteger, "", {}}});
  return definition;
}

const EffectDefinition& LearntJumpDeviation() {
  static const EffectDefinition definition = [] {
    SettingDefinition to{"to", Kind::kNumber, "", {}};
    to.greater_than = "from";
    return OfJoint({"learnt_jump_deviation", "learnt jump of a joint", "jump between two places of a joint",
                    EffectTarget::kJoint, JumpWeight, DeviateByJump},
                   {{"from", Kind::kNumber, "", {}}, to});
  }();
  return definition;
}

}  // namespace sagitta
