// report.html: one self-contained page for people.
#pragma once

#include <string>

#include "estimator/estimate.h"
#include "problems/calibration_problem.h"
#include "tools/estimate_json.h"

namespace sagitta {

std::string ReportToHtml(const CalibrationProblem& problem, const Estimate& estimate, const Provenance& provenance);

std::string EscapeHtml(const std::string& text);

}  // namespace sagitta
