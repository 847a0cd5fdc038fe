// Measured points move by (v + omega x p) exp(-t / tau) while the instrument and
// its stand come to their temperature: t from the station's first row or from
// the end of its last pause. An instrument that stayed on in the pauses (`pauses:
// go_on`) is one that none interrupted.
#include <algorithm>
#include <map>
#include <utility>

#include "models/effects/catalogue.h"
#include "models/quantiles.h"

namespace sagitta {
namespace warm_up {

// A gap that is this many times the usual (median) one from pose to pose is a pause.
constexpr double kPausePerGap = 10.0;
constexpr char kBeginAnew[] = "begin_anew", kGoOn[] = "go_on";

std::vector<EffectParameter> Parameters(const Robot&, const EffectSpec&) {
  return {{"x", Quantity::kShift, 30e-6},       {"y", Quantity::kShift, 30e-6},
          {"z", Quantity::kShift, 30e-6},       {"rx", Quantity::kSmallAngle, 10e-6},
          {"ry", Quantity::kSmallAngle, 10e-6}, {"rz", Quantity::kSmallAngle, 10e-6}};
}

// Between poses, s; 0 for a single one.
double MedianGap(const std::vector<const ShotConditions*>& shots) {
  std::vector<double> gaps;
  for (size_t i = 1; i < shots.size(); ++i) {
    if (shots[i]->q != shots[i - 1]->q) gaps.push_back(shots[i]->station_time - shots[i - 1]->station_time);
  }
  return Median(std::move(gaps));
}

// Time since the station was last begun with, s.
std::vector<double> Remember(const Robot&, const EffectSpec& spec, const std::vector<const ShotConditions*>& campaign) {
  std::vector<const ShotConditions*> own;
  for (const ShotConditions* shot : campaign) {
    if (shot->station == spec.target) own.push_back(shot);
  }
  const double pause = spec.TextSetting("pauses", kBeginAnew) == kBeginAnew ? kPausePerGap * MedianGap(own) : 0.0;
  double begun = 0.0, last = 0.0;
  bool any = false;
  std::vector<double> since;
  for (const ShotConditions* shot : campaign) {
    if (shot->station != spec.target) {
      since.push_back(0.0);
      continue;
    }
    const double now = shot->station_time;
    if (any && pause > 0.0 && now - last > pause) begun = now;
    if (!any) begun = std::min(0.0, now);
    any = true;
    last = now;
    since.push_back(now - begun);
  }
  return since;
}

void Apply(const EffectContext& context, ShotTerms* terms) {
  if (context.shot->station != context.spec->target) return;
  const double left = std::exp(-context.memory / context.spec->NumberSetting("tau_s", 1800.0));
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3<double> unit = Vector3<double>::Unit(axis);
    terms->station.push_back({context.first_parameter + axis, Matrix3<double>::Zero(), left * unit});
    terms->station.push_back({context.first_parameter + 3 + axis, left * Skew(unit), Vector3<double>::Zero()});
  }
}

}  // namespace warm_up

const EffectDefinition& WarmUp() {
  static const EffectDefinition definition = [] {
    EffectDefinition effect{"warm_up",
                            "warming up of the instrument",
                            "first-order approach to thermal equilibrium",
                            EffectTarget::kStation,
                            warm_up::Parameters,
                            warm_up::Apply};
    // Columns of neighbouring time constants correlate above 0.95.
    effect.settings = {
        {"tau_s", SettingDefinition::Kind::kNumber, "", {"300", "600", "1200", "2400", "4800"}},
        {"pauses", SettingDefinition::Kind::kChoice, warm_up::kBeginAnew, {warm_up::kBeginAnew, warm_up::kGoOn}}};
    effect.settings[0].above = 0.0;
    effect.settings[1].silent = true;
    effect.settings[1].is_of_memory = true;
    effect.driven_by = EffectDriver::kTime;
    effect.separate_by = "the first poses repeated after an hour, and again at the end";
    effect.sizes =
        "laser trackers settle by some 30 um and 10 urad in the first hour: makers ask for 30 to 60 min of "
        "warming up (ISO 10360-10:2021, rated operating conditions)";
    effect.remember = warm_up::Remember;
    return effect;
  }();
  return definition;
}

}  // namespace sagitta
