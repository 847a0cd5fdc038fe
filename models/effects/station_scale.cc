// measured = (1 + scale) * true about the instrument. Testable between stations or
// with frozen lengths only.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) { return {{"scale", Quantity::kRatio}}; }

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  terms->station.push_back({context.first_parameter, Matrix3<double>::Identity(), -context.shot->instrument});
}

}  // namespace

const EffectDefinition& StationScale() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"station_scale",
                            "scale of the instrument",
                            "refraction, wavelength",
                            EffectTarget::kStation,
                            Parameters,
                            Apply};
    effect.separate_by = "a calibrated length in view of the station, or the same points from another one";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
