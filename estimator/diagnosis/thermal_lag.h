// The arm follows the thermometer late. A link of heat capacity C that loses heat at W per kelvin obeys
//
//   dT_arm/dt = (T - T_arm) / tau,   tau = C / W   (Newton's law of cooling)
//
// tau is a setting of the effect (thermal_growth.cc) and no parameter: a growth fitted with another one is biased. So
// the interval of what temperature drives is widened to the profile likelihood over tau. Where the shots state no time,
// they are assumed to be in their order, one a minute: if that is wrong, the data contradict all but short lags, and
// little is widened.
#pragma once

#include <optional>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

struct ThermalLag {
  double best = 0.0;                     // s
  double shortest = 0.0, longest = 0.0;  // s, that the data do not contradict at 95 %
  bool is_timed = false;                 // the shots state their time
};

// Widens `rows`, the effect's parameters in the final model, to what any lag up to half an hour (or twice the one that
// the effect states) leaves possible; values stay. None, and nothing changed, where the effect is not driven by
// temperature.
std::optional<ThermalLag> AllowForLag(const DiagnosedModel& final, const EffectSpec& spec,
                                      std::vector<ParameterEstimate>* rows);

}  // namespace sagitta
