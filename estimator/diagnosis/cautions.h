// What limits the verdict whatever the search finds: data that cannot hold the
// answer. Each in words, with a remedy.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estimator/diagnosis/diagnose.h"

namespace sagitta {

// Rows that are stated in another way than the robot reads them; no effect is the answer to that.
std::vector<std::string> CautionsOfReadings(const CalibrationProblem& problem);

// Of the problem as it was stated, and of the believed model with the noise and without the outliers that were found.
std::vector<std::string> FindCautions(const CalibrationProblem& stated, const DiagnosedModel& believed);

// Of effects on which two halves of the poses disagree: the least p of so many is below kHalvesContradict by chance in
// as many of a hundred diagnoses as one effect's would be.
void CautionOfHalves(const std::vector<FoundEffect>& effects, std::vector<std::string>* cautions);

// Of effects in place of which another value of a stated one does as well (stated_effects.h).
void CautionOfStatedEffects(const DiagnosedModel& lacking, const JointOptions& options,
                            std::vector<FoundEffect>* effects, std::vector<std::string>* cautions);

// Of what something else would move alike: compliances that were found where every fitted row carries the same load,
// for links bend the arm, too; the scale of a station where no row states how warm the arm was.
void CautionOfLookAlikes(const CalibrationProblem& problem, const std::vector<FoundEffect>& effects,
                         std::vector<std::string>* cautions);

// Of effects that are probable by themselves and not named, but for those that untouched rows did not confirm.
void CautionOfNotNamed(const std::vector<std::pair<EffectSpec, double>>& unconfirmed, Diagnosis* diagnosis);

// Where something is left and a few configurations have most of it; where the hold-out is far above its noise floor
// although nothing is left to explain it, or below a floor of stated
// noise.
void CautionOfHoldout(const DiagnosedModel& final, bool has_unexplained, bool is_sigma_stated, double significance,
                      std::vector<std::string>* cautions);

}  // namespace sagitta
