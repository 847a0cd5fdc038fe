// Numbers of an effect that its definition states and the diagnosis scans: a play's width, a time constant. The list of
// candidates holds a few values of each, which do not do where the effect is many standard deviations large: what the
// nearest listed value leaves over looks like one more effect. So the full model is refitted between them, and what
// each value would make of the effect's parameters is part of their intervals.
#pragma once

#include <vector>

#include "estimator/diagnosis/selected_effects.h"
#include "estimator/diagnosis/setting_profile.h"

namespace sagitta {

// Each scanned setting of a refitted set's effects where chi-square is least, the other effects estimated with it; the
// set is refitted where that is worth as much as kInDoubt in log likelihood. Returns the gain, 0 where it stays.
double TuneSettings(const Evidence& evidence, const JointOptions& joint, RefittedSet* refitted);

// Widens `rows`, the effect's parameters in the final model, to what any value of its scanned setting leaves possible,
// listed or between; values stay.
void AllowForSetting(const DiagnosedModel& final, const EffectSpec& spec, std::vector<ParameterEstimate>* rows);

}  // namespace sagitta
