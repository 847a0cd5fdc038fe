// Effects of the robot file whose values are believed, and no candidates: where one of these is off, an effect of its
// kind on a neighbouring joint, station or load may be found in its place.
#pragma once

#include <vector>

#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

// Stated effects of the kind of the k-th found one, other values of which explain the fitted rows about as well in its
// place. lacking: the believed model, with the noise that goes with what was found.
std::vector<EffectSpec> StatedInPlaceOf(const DiagnosedModel& lacking, const std::vector<Candidate>& found, size_t k,
                                        const JointOptions& options);

// What the robot file states and the experiment holds.
std::vector<EffectSpec> HeldEffects(const CalibrationProblem& problem);

}  // namespace sagitta
