// Numbers of an effect that its definition states and the diagnosis scans: a play's width, a time constant. The list of
// candidates holds a few values of each, which do not do where the effect is many standard deviations large: what the
// nearest listed value leaves over looks like one more effect. So the full model is refitted between them, and what
// each value would make of the effect's parameters is part of their intervals.
#pragma once

#include <optional>
#include <vector>

#include "estimator/diagnosis/selected_effects.h"

namespace sagitta {

// Each scanned setting of a refitted set's effects where chi-square is least, the other effects estimated with it; the
// set is refitted where that is worth as much as kInDoubt in log likelihood. Returns the gain, 0 where it stays.
double TuneSettings(const Evidence& evidence, const JointOptions& joint, RefittedSet* refitted);

// Widens `rows`, the effect's parameters in the final model, to what any value of its scanned setting leaves possible,
// listed or between, and any lag from none to half an hour (or twice the one that the effect states), by the profile
// likelihood: all values v with, at some number,
//   chi2(number) + (v - v(number))^2 / sigma(number)^2 <= least + q^2,
// joined with the interval that the row has, of which q is. Values stay. Returns what numbers are possible, where the
// effect has such a setting and the rows determine a value of it at all.
std::optional<PossibleNumbers> AllowForSetting(const DiagnosedModel& final, const EffectSpec& spec,
                                               std::vector<ParameterEstimate>* rows);

}  // namespace sagitta
