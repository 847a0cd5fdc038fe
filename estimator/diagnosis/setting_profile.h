// One number that is no parameter of an effect (how late the arm is, the width of a play, a time constant) at many
// values, the model refitted at each: its likelihood, and what an effect's parameters may be for any of them.
#pragma once

#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

struct FitAt {
  double at = 0.0;  // the number, SI or the setting's own unit
  EffectSpec spec;  // what the effect is called in this fit
  QuickRefit refit;

  double chi2() const { return refit.estimate.chi2; }
};

// The one with the least chi-square. fits: not empty.
const FitAt& BestOf(const std::vector<FitAt>& fits);

// The model with `changed` in place of an effect that it has, at the same values, not yet refitted. Both have the same
// parameters.
DiagnosedModel WithInstead(const DiagnosedModel& model, const EffectSpec& spec, const EffectSpec& changed);

// A row of `spec` in the final model, by the profile likelihood: all values v with, at some number,
//   chi2(number) + (v - v(number))^2 / sigma(number)^2 <= least + q^2,
// joined with the interval that the row has, of which q is. own: the number of that row's fit, of which the noise is.
void Widen(const std::vector<FitAt>& fits, double own, const EffectSpec& spec, ParameterEstimate* row);

// Of the noise that the row's interval goes by, in that of the refit at `own`; 0 where that does not determine the row.
double NoiseOfRow(const std::vector<FitAt>& fits, double own, const EffectSpec& spec, const ParameterEstimate& row);

}  // namespace sagitta
