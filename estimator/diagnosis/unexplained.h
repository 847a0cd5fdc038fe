// Does the catalogue explain the gap, or do its effects only imitate a cause that
// it does not hold? Decoys compete with the steps: a decoy replaces those whose gain
// falls below half beside everything of its kind, and where it and the others beat all steps,
// by the penalised chi-square of FORMATS section 6, the rest has no name. What then
// still holds beside everything of the decoy's kind is kept.
#pragma once

#include <vector>

#include "estimator/diagnosis/decoys.h"
#include "estimator/diagnosis/selection.h"

namespace sagitta {

constexpr double kUnknownMargin = 6.0;  // penalised lead of a decoy over one catalogue step

struct Unexplained {
  bool found = false;
  Decoy decoy;  // the best on what the remaining steps leave
};

// `steps` are what was selected, `model` the baseline with them; both become what holds.
Unexplained KeepWhatHolds(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates,
                          const SelectionOptions& options, std::vector<ChosenStep>* steps, DiagnosedModel* model);

}  // namespace sagitta
