// What limits the verdict whatever the search finds: data that cannot hold the
// answer. Each in words, with a remedy.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/selection.h"

namespace sagitta {

std::vector<std::string> FindCautions(const DiagnosedModel& believed);

}  // namespace sagitta
