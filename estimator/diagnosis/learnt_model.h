// What has no name, added to the model as smooth functions (models/effects/learnt_deviation.cc): the gap shrinks even
// where the catalogue has no word. It describes; it names nothing.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "estimator/diagnosis/gap.h"
#include "estimator/evidence/evidence.h"
#include "estimator/evidence/pose_groups.h"

namespace sagitta {

struct LearntModel {
  std::vector<EffectSpec> functions;  // with values, the most probable first
  DiagnosedModel model;               // with the effects and these
  GapReport gap;                      // from the believed model
};

// With the effects that `final` has: the functions without a name that the leading set holds; then others, the best one
// after the other, while each has odds of 20 for it and predicts groups of poses better that are left out of the fit,
// beyond chance (gap.h); fitted with the prior that their evidence is made of. Effects of the catalogue that are pieces
// of the nameless cause (nameless_cause.h) come last: given the functions they explain what is left. The configurations
// held out choose nothing; they say whether all together predict them better. Nothing where they do not, or where no
// function is left.
std::optional<LearntModel> LearnModel(const Evidence& evidence, const WeightedModel& leading, const PoseGroups& groups,
                                      const DiagnosedModel& baseline, const DiagnosedModel& final,
                                      const JointOptions& joint);

// Where poses lie further apart than bumps are wide, these by themselves are zero between them: wider ones next to them
// carry the function over. The function's effect and what goes with it, each with the standard deviation of its
// weights that makes it as steep as the others are (`scale` for the effect's own). gap: largest distance between
// neighbouring values of the driver on fitted shots, in the unit of the effect's `from` and `to`.
std::vector<std::pair<EffectSpec, double>> LevelsOf(const EffectSpec& spec, double scale, double gap);

}  // namespace sagitta
