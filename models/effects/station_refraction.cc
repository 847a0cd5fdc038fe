// The line of sight is bent by a vertical gradient of temperature. A ray of
// curvature kappa (1/m) that is assumed to be straight at its arrival seems to come
// from above by the angle between chord and tangent: elevation too large by
// kappa s / 2 at the range s. kappa = -(d n / d T)(d T / d z) / n = 0.95e-6 1/K times
// the gradient for visible light in air (Ciddor, Applied Optics 35 (1996) 1566).
#include "models/effects/catalogue.h"

namespace sagitta {
namespace station_refraction {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"curvature", Quantity::kCurvature, 1e-6}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  terms->sights.push_back(
      {context.first_parameter, Sensed::kElevation, SightLaw::kRange, context.shot->instrument, 0.5});
}

}  // namespace station_refraction

const EffectDefinition& StationRefraction() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "station_refraction",   "bent line of sight",           "refraction in a vertical gradient of temperature",
        EffectTarget::kStation, station_refraction::Parameters, station_refraction::Apply};
    effect.separate_by = "the same poses from a second station at another distance";
    effect.note = "It counts from instrument_mm of the station; where that is not stated, from the origin.";
    effect.sizes = "1 K per metre of height in a hall: 0.95 urad/m, 12 um at 5 m";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
