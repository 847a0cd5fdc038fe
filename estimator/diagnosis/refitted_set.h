// The best sets once more, in the full model: where it has no optimum a set is none, and what the linear model promised
// is replaced by what the full one keeps.
//
// With D the residual's square at the best values, linear and full,
//
//   log weight += log f(D_full) - log f(D_linear)
//
// which leaves determinants and priors as they are: they change little over the few standard deviations that the two
// optima are apart.
#pragma once

#include <vector>

#include "estimator/diagnosis/selected_effects.h"

namespace sagitta {

struct RefittedSet {
  WeightedModel model;
  DiagnosedModel lacking;               // the believed model beside the noise that goes with the set
  std::vector<SelectedEffect> effects;  // of the catalogue
  DiagnosedModel with_effects;

  bool IsUsable() const { return sagitta::IsUsable(with_effects.estimate.status); }
};

// working: what the evidence is made of. baseline: fitted with the noise as stated. near: another set with a noise like
// that of this one, to start from.
RefittedSet RefitSet(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& working,
                     const DiagnosedModel& baseline, const JointOptions& joint, const RefittedSet* near = nullptr);

// 0 where the set holds what has no name: the full model cannot hold it.
double LogCorrection(const Evidence& evidence, const RefittedSet& refitted);

// The most probable sets by name, refitted; `evidence` and `posterior` follow. The leading one is returned: of those
// with an optimum in the full model, or the first as it is where none has one.
RefittedSet RefitLeading(const CalibrationProblem& working, const DiagnosedModel& baseline, const JointOptions& joint,
                         Evidence* evidence, Posterior* posterior);

}  // namespace sagitta
