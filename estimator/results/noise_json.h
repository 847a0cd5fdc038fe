// The key `noise` of estimate.json: variance components, spreads, outliers.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

nlohmann::ordered_json NoiseToJson(const CalibrationProblem& problem, const Estimate& estimate);

}  // namespace sagitta
