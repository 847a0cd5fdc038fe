// measured = (1 + scale) * true about the instrument. Testable between stations or
// with frozen lengths only.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace station_scale {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"scale", Quantity::kRatio, 10e-6}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  terms->station.push_back({context.first_parameter, Matrix3<double>::Identity(), -context.shot->instrument});
}

}  // namespace station_scale

const EffectDefinition& StationScale() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"station_scale",        "scale of the instrument", "refraction, wavelength",
                            EffectTarget::kStation, station_scale::Parameters, station_scale::Apply};
    effect.separate_by = "a calibrated length in view of the station, or the same points from another one";
    effect.sizes =
        "0.95 ppm/K and 0.27 ppm/hPa of air that is not compensated for (Ciddor, Applied Optics 35 (1996) 1566)";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
