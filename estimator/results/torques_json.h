// The block `torques`: measured joint torques against the modelled ones.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estimator/inspection/torque_lint.h"

namespace sagitta {

// {"used": "measured", "joints": [...], "words"}; empty where no row states torques.
nlohmann::ordered_json TorquesToJson(const CalibrationProblem& problem, const TorqueComparison& comparison);

}  // namespace sagitta
