// What limits the verdict whatever the search finds: data that cannot hold the
// answer. Each in words, with a remedy.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/selection.h"

namespace sagitta {

std::vector<std::string> FindCautions(const DiagnosedModel& believed);

// Where nothing is left that would explain it, and the hold-out is far above its noise floor all the same.
void CautionOfHoldout(const DiagnosedModel& final, bool has_unexplained, std::vector<std::string>* cautions);

}  // namespace sagitta
