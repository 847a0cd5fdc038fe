// What hangs on the arm, in estimate.json: predict needs it for the loads and
// the tool of the experiment that was estimated.
#pragma once

#include <nlohmann/json.hpp>

#include "problems/experiment.h"

namespace sagitta {

nlohmann::ordered_json LoadingToJson(const Experiment& experiment);

// Fills load point, loads, tool and gravity. Throws nlohmann::json::exception
// for anything that LoadingToJson does not write.
void ReadLoading(const nlohmann::ordered_json& json, Experiment* experiment);

}  // namespace sagitta
