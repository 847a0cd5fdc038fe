// diagnosis.json (sagitta/diagnosis/1, FORMATS section 6).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "estimator/diagnosis/diagnose.h"

namespace sagitta {

nlohmann::ordered_json DiagnosisToJson(const Diagnosis& diagnosis, double significance);

// The robot with what was found, compliances in their homes.
Robot RobotOf(const DiagnosedModel& model);

// The proposed poses (Diagnosis::next) as a measurement file to fill in: the columns of the first one, rows of the
// configurations that they are like. Their names go on after those of the data, and the split fits them
// (problems/split.h).
std::string NextToCsv(const Diagnosis& diagnosis);

}  // namespace sagitta
