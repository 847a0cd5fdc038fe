// Measured against simulated over what drives an effect, for people to look at: per
// visit, the deviation of the effect's joint (or the size of the effect) that the
// measurements ask for, and what the effect says.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

struct EffectView {
  std::string driver, driver_unit;  // horizontal: a joint's angle, time, temperature, configuration number
  std::string quantity, unit;       // vertical
  std::vector<double> x;            // one per visit
  std::vector<double> measured;     // what the model leaves where the effect is taken out of it
  std::vector<double> simulated;    // what the effect says
};

// Of effects that a model has.
std::vector<EffectView> ViewEffects(const DiagnosedModel& with, const std::vector<EffectSpec>& specs);

}  // namespace sagitta
