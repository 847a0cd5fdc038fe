// What an inspection says to people: terminal and page.
#pragma once

#include <string>
#include <vector>

#include "estimator/inspection/inspect.h"
#include "estimator/results/provenance.h"
#include "tools/report/summary.h"

namespace sagitta {

std::vector<Section> SummariseInspection(const CalibrationProblem& problem, const Inspection& inspection);

std::string InspectionToHtml(const CalibrationProblem& problem, const Inspection& inspection,
                             const Provenance& provenance);

}  // namespace sagitta
