// report.html of a diagnosis: where simulation and measurement disagree, what was found, the gap before and after.
#pragma once

#include <string>

#include "estimator/diagnosis/diagnose.h"
#include "estimator/results/estimate_json.h"

namespace sagitta {

std::string DiagnosisToHtml(const Diagnosis& diagnosis, const Provenance& provenance);

}  // namespace sagitta
