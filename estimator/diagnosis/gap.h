// The gap on configurations that nothing was chosen or fitted on:
// gap^2 = holdout rms^2 - noise floor^2, closed = 1 - after^2 / before^2.
#pragma once

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

// Not a number without a hold-out, and where nothing states the noise: a floor that is the model's own scatter would
// call every gap closed. No interval below three held-out configurations.
struct GapReport {
  double before = 0.0, after = 0.0;  // m
  double closed = 0.0;               // share of the squared gap
  Interval closed_ci95;              // bootstrap over hold-out configurations
};

// RMS over the coordinates of the hold-out, m; not a number without one.
double HoldoutRms(const DiagnosedModel& model);

// How much of the gap of the baseline the extended model closes on the hold-out.
GapReport JudgeGap(const DiagnosedModel& baseline, const DiagnosedModel& extended, bool is_noise_stated);

}  // namespace sagitta
