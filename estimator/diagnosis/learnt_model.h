// What has no name, added to the model as smooth functions (models/effects/learnt_deviation.cc): the gap shrinks even
// where the catalogue has no word. It describes; it names nothing.
#pragma once

#include <optional>
#include <vector>

#include "estimator/diagnosis/evidence.h"
#include "estimator/diagnosis/gap.h"

namespace sagitta {

struct LearntModel {
  std::vector<EffectSpec> functions;  // with values, the most probable first
  DiagnosedModel model;               // with the effects and these
  GapReport gap;                      // from the believed model
};

// Beside the effects that `final` has: unnamed functions, the best one after the other, while each has odds of 20 for
// it and does not make untouched rows worse beyond chance; fitted with the prior that their evidence is made of.
// Nothing where none is left, or where all together predict untouched rows no better.
std::optional<LearntModel> LearnModel(const Evidence& evidence, const WeightedModel& leading,
                                      const DiagnosedModel& baseline, const DiagnosedModel& final,
                                      const JointOptions& joint);

}  // namespace sagitta
