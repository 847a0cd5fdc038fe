// What is weighed, averaged over resamples of the poses.
//
// A probability assumes that the cause is in the list and that the noise is as said. Given a rest without a name that
// is known to be wrong: of several sums of effects that describe the rest about as well, one is far ahead on these
// poses and another one would be on others. Posteriors that are averaged over bootstrap samples (bagged) say how much
// of that is chance, and say the same on other data (Huggins and Miller, Bayesian Analysis 18 (2023) 79; Reproducible
// model selection using bagged posteriors).
#pragma once

#include <vector>

#include "estimator/evidence/pose_groups.h"

namespace sagitta {

// The evidence's models, averaged with the most probable set of each of kResamples resamples in the leading model's
// view; all poses as they are count as one of them. The search begins with nothing on each, among what the groups ask
// for. Where the leading set holds nothing, or poses are too few, these are the evidence's models as they are.
std::vector<WeightedModel> BaggedModels(const Evidence& evidence, const WeightedModel& leading,
                                        const PoseGroups& groups);

constexpr int kResamples = 10;  // one moves a probability by 0.09, less than chance does from resample to resample

}  // namespace sagitta
