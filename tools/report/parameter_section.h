// The table of parameters, and what is shown of each: tables and pictures of one report have the same intervals.
#pragma once

#include <string>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"
#include "tools/report/summary.h"

namespace sagitta {

// With the interval that people are shown: what held parameters may be is in it.
ParameterEstimate AsShown(ParameterEstimate row);

// "held", "conditional", "at bound", "weak", ...; "" where nothing is to be said.
std::string StateOf(const ParameterEstimate& row, const Estimate& estimate);

// model_error: as in Summarise.
Section ParameterSection(const CalibrationProblem& problem, const Estimate& estimate, double model_error);

}  // namespace sagitta
