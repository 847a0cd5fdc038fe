// Units that no header states: every reading of them is a plan of its own.
#pragma once

#include <vector>

#include "problems/io/import/import_plan.h"

namespace sagitta {

std::vector<ImportPlan> WithOpenUnits(std::vector<ImportPlan> plans, const std::vector<Joint>& joints);

}  // namespace sagitta
