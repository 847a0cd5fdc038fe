// The circles of the instrument are read off centre: azimuth and elevation have
// a once-per-turn error. A graduated circle of radius r whose centre is off the
// axis of rotation by (e_x, e_y) is read wrong by (e_y cos a - e_x sin a) / r.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace station_eccentricity {

constexpr double kTypical = 15e-6;  // rad

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"az_cos", Quantity::kSmallAngle, kTypical},
          {"az_sin", Quantity::kSmallAngle, kTypical},
          {"el_cos", Quantity::kSmallAngle, kTypical},
          {"el_sin", Quantity::kSmallAngle, kTypical}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  const std::pair<Sensed, SightLaw> errors[4] = {{Sensed::kAzimuth, SightLaw::kCosAzimuth},
                                                 {Sensed::kAzimuth, SightLaw::kSinAzimuth},
                                                 {Sensed::kElevation, SightLaw::kCosElevation},
                                                 {Sensed::kElevation, SightLaw::kSinElevation}};
  for (int i = 0; i < 4; ++i) {
    terms->sights.push_back({context.first_parameter + i, errors[i].first, errors[i].second, context.shot->instrument});
  }
}

}  // namespace station_eccentricity

const EffectDefinition& StationEccentricity() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"station_eccentricity",
                            "eccentric circles of the instrument",
                            "Muralikrishnan et al., J. Res. NIST 114 (2009) 21",
                            EffectTarget::kStation,
                            station_eccentricity::Parameters,
                            station_eccentricity::Apply};
    effect.separate_by = "the same poses from a second station, or in the instrument's other face";
    effect.note = "It counts from instrument_mm of the station; where that is not stated, from the origin.";
    effect.sizes =
        "0.6 um off centre on a circle of 40 mm radius: two-face errors of trackers within their "
        "specification (ASME B89.4.19-2006, appendix on two-face tests)";
    effect.largest = 1.0;
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
