// inspect.json (sagitta/inspection/1), and the same for people.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "estimator/inspect/inspect.h"
#include "tools/estimate_json.h"
#include "tools/summary.h"

namespace sagitta {

nlohmann::ordered_json InspectionToJson(const CalibrationProblem& problem, const Inspection& inspection,
                                        const Provenance& provenance);

std::vector<Section> SummariseInspection(const CalibrationProblem& problem, const Inspection& inspection);

std::string InspectionToHtml(const CalibrationProblem& problem, const Inspection& inspection,
                             const Provenance& provenance);

}  // namespace sagitta
