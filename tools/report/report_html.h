// report.html: one self-contained page for people.
#pragma once

#include <string>

#include "estimator/estimate/estimate.h"
#include "estimator/results/estimate_json.h"
#include "problems/calibration_problem.h"
#include "tools/report/summary.h"

namespace sagitta {

// A page of sections, the first one its heading, and charts (SVG).
std::string SectionsToPage(const std::vector<Section>& sections, const std::string& charts,
                           const Provenance& provenance);

// Whitened residuals as histograms, residuals per configuration.
std::string ResidualCharts(const CalibrationProblem& problem, const Estimate& estimate);

std::string ReportToHtml(const CalibrationProblem& problem, const Estimate& estimate, const Provenance& provenance);

}  // namespace sagitta
