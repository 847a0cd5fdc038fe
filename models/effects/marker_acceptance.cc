// A reflector seen at an angle: its centre shifts along the line of sight with
// the square of the angle of incidence. Its axis is fixed to what it rides on:
// the flange's own axis, that of the last joint, unless stated otherwise.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace marker_acceptance {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"offset", Quantity::kShift, 50e-6}};
}

std::string FlangeAxis(const Robot& robot) {
  const int joints = robot.num_joints();
  const Axis axis = joints > 0 ? AxisOf(robot.chain, joints - 1) : Axis::kZ;
  return std::string(1, static_cast<char>('x' + static_cast<int>(axis)));
}

Vector3<double> AxisOfMarker(const EffectContext& context) {
  const std::string named = context.spec->TextSetting("axis", FlangeAxis(*context.robot));
  return (named[0] == '-' ? -1.0 : 1.0) * Vector3<double>::Unit(named.back() - 'x');
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  for (size_t m = 0; m < context.markers->size(); ++m) {
    if ((*context.markers)[m] != context.spec->target) continue;
    terms->sights.push_back({context.first_parameter, Sensed::kRange, SightLaw::kSquaredIncidence,
                             context.shot->instrument, 1.0, static_cast<int>(m), AxisOfMarker(context)});
  }
}

}  // namespace marker_acceptance

const EffectDefinition& MarkerAcceptance() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"marker_acceptance",
                            "reflector seen at an angle",
                            "acceptance-angle error of spherically mounted retroreflectors",
                            EffectTarget::kMarker,
                            marker_acceptance::Parameters,
                            marker_acceptance::Apply};
    effect.settings = {{"axis", SettingDefinition::Kind::kChoice, "", {"x", "-x", "y", "-y", "z", "-z"}}};
    effect.settings[0].silent = true;
    effect.settings[0].one_each = true;
    effect.settings[0].fallback_of = marker_acceptance::FlangeAxis;
    effect.separate_by = "the same poses with the reflector turned in its nest, or from a second station";
    effect.sizes = "13 um at the 30 degrees (0.27 rad^2) that data sheets of reflectors allow";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
