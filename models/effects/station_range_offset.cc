// Readings are too long by a constant along the line of sight: the home distance
// of the instrument, or the constant of its reflector.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace station_range_offset {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"offset", Quantity::kShift, 0.5e-3}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  terms->sights.push_back({context.first_parameter, Sensed::kRange, SightLaw::kOne, context.shot->instrument});
}

}  // namespace station_range_offset

const EffectDefinition& StationRangeOffset() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{
        "station_range_offset", "range offset of the instrument", "ranging parameter R0, ASME B89.4.19-2006",
        EffectTarget::kStation, station_range_offset::Parameters, station_range_offset::Apply};
    effect.separate_by = "a calibrated length measured in line with the instrument and from its middle";
    effect.note =
        "It counts from instrument_mm of the station; where that is not stated, from the origin. A reflector's radius "
        "that is not corrected is one, too.";
    effect.sizes =
        "between R0 of absolute distance meters, 10 to 25 um in tracker data sheets, and the radius of a reflector, "
        "6.35, 12.7 or 19.05 mm";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
