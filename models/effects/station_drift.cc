// Measured points move: p + t v + t omega x p in the measurement frame.
#include "models/effects/catalogue.h"

namespace sagitta {
namespace station_drift {

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"x", Quantity::kDrift, 15e-6 / 3600},    {"y", Quantity::kDrift, 15e-6 / 3600},
          {"z", Quantity::kDrift, 15e-6 / 3600},    {"rx", Quantity::kTurnRate, 5e-6 / 3600},
          {"ry", Quantity::kTurnRate, 5e-6 / 3600}, {"rz", Quantity::kTurnRate, 5e-6 / 3600}};
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  const double t = context.shot->station_time;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3<double> unit = Vector3<double>::Unit(axis);
    terms->station.push_back({context.first_parameter + axis, Matrix3<double>::Zero(), t * unit});
    terms->station.push_back({context.first_parameter + 3 + axis, t * Skew(unit), Vector3<double>::Zero()});
  }
}

}  // namespace station_drift

const EffectDefinition& StationDrift() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"station_drift",        "drift of the station",    "stand or foundation moves",
                            EffectTarget::kStation, station_drift::Parameters, station_drift::Apply};
    effect.driven_by = EffectDriver::kTime;
    effect.separate_by = kSeparateByReturn;
    effect.sizes =
        "a stand of 1.5 m that warms by 1 K per hour: 17 um/h, and 5 urad/h where its legs differ by a third";
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
