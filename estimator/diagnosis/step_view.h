// Measured against simulated over what drives a step, for people to look at: per
// visit, the deviation of the step's joint (or the size of the effect) that the
// measurements ask for, and what the step says.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

struct StepView {
  std::string driver, driver_unit;  // horizontal: a joint's angle, time, temperature, configuration number
  std::string quantity, unit;       // vertical
  std::vector<double> x;            // one per visit
  std::vector<double> measured;     // what the model leaves where the step is taken out of it
  std::vector<double> simulated;    // what the step says
};

// Of a model that has the effect.
StepView ViewStep(const DiagnosedModel& with, const EffectSpec& spec);

}  // namespace sagitta
