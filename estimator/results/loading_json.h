// What hangs on the arm, and what time and temperature count from, in estimate.json: predict needs the loads and the
// tool of the experiment that was estimated, and drift and growth mean the same in other rows.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "problems/experiment.h"
#include "problems/io/json_reader.h"
#include "problems/measurements.h"

namespace sagitta {

nlohmann::ordered_json LoadingToJson(const Experiment& experiment, const Measurements& data);

// Fills load point, loads, tool, gravity and origins. Throws InputError for anything that LoadingToJson does not write.
void ReadLoading(const JsonValue& json, Experiment* experiment);

}  // namespace sagitta
