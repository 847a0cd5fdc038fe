// inspect.json (sagitta/inspection/1).
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estimator/inspection/inspect.h"
#include "estimator/results/estimate_json.h"

namespace sagitta {

nlohmann::ordered_json InspectionToJson(const CalibrationProblem& problem, const Inspection& inspection,
                                        const Provenance& provenance);

}  // namespace sagitta
