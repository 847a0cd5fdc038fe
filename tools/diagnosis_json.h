// diagnosis.json (sagitta/diagnosis/1, FORMATS section 6) and its words.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "estimator/diagnosis/diagnose.h"

namespace sagitta {

nlohmann::ordered_json DiagnosisToJson(const Diagnosis& diagnosis, double significance);

// The terminal summary.
std::string DiagnosisToText(const Diagnosis& diagnosis);

// "Axis A3: periodic joint error, order 1: cos 210 ± 8 urad, ...".
std::string StepInWords(const DiagnosisStep& step);

// The robot with what was found, compliances in their homes.
Robot ExtendedRobot(const Diagnosis& diagnosis);

}  // namespace sagitta
