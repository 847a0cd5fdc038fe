// Encoder side: what follows q with a play of width w lags behind it by up to
// half of that. Play operator y (Prandtl-Ishlinskii; Krejci, Hysteresis, Convexity
// and Dissipation in Hyperbolic Equations, 1996), r = w / 2, along the shots:
//
//   y_k = max(q_k - r, min(q_k + r, y_(k-1))),   y_0 = q_0
//
// deviation = amplitude (y - q) / r: -amplitude after a way of more than w in the
// positive direction, +amplitude in the negative one, in between on a reversal.
#include <algorithm>

#include "models/constants.h"
#include "models/effects/catalogue.h"

namespace sagitta {
namespace hysteresis {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"amplitude", Quantity::kSmallAngle, 50e-6}};
}

// (y - q) / r.
std::vector<double> Remember(const Robot& robot, const EffectSpec& spec,
                             const std::vector<const ShotConditions*>& campaign) {
  const int joint = robot.chain.FindJoint(spec.target);
  const double r = 0.5 * kDegree * spec.NumberSetting("width_deg", 1.0);
  std::vector<double> behind;
  double y = campaign.empty() ? 0.0 : campaign[0]->q[joint];
  for (const ShotConditions* shot : campaign) {
    const double q = shot->q[joint];
    y = std::max(q - r, std::min(q + r, y));
    behind.push_back((y - q) / r);
  }
  return behind;
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  terms->slots.push_back({context.joint_slot(), context.first_parameter, context.joint_sign() * context.memory});
}

}  // namespace hysteresis

const EffectDefinition& Hysteresis() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"hysteresis",         "hysteresis with memory", "play operator, Prandtl-Ishlinskii",
                            EffectTarget::kJoint, hysteresis::Parameters,   hysteresis::Apply};
    effect.settings = {{"width_deg", SettingDefinition::Kind::kNumber, "", {"1", "3", "10", "30"}}};
    effect.settings[0].above = 0.0;
    effect.separate_by = "the same poses approached from both sides, after short ways and after long ones";
    effect.note =
        "The poses' order is their time, or the rows' where no time is stated; what the arm did between them "
        "is not known.";
    effect.sizes =
        "hysteresis loss of strain wave and cycloidal gears: below 1 arcmin (291 urad) at rated torque, a "
        "third of its half in motion without load (makers' data sheets)";
    effect.remember = hysteresis::Remember;
    effect.largest = 1.0;
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
