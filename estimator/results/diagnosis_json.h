// diagnosis.json (sagitta/diagnosis/1, FORMATS section 6).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "estimator/diagnosis/diagnose.h"

namespace sagitta {

nlohmann::ordered_json DiagnosisToJson(const Diagnosis& diagnosis, double significance);

// The robot with what was found, compliances in their homes.
Robot RobotOf(const DiagnosedModel& model);

}  // namespace sagitta
