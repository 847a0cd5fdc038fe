// report.html of a diagnosis: where simulation and measurement disagree, what was found, the gap before and after.
#pragma once

#include <string>

#include "estimator/results/estimate_json.h"
#include "estimator/sagitta.h"

namespace sagitta {

// extended: its extended model, judged (ExtendedCalibration).
std::string DiagnosisToHtml(const Diagnosis& diagnosis, const Calibration& extended, const Provenance& provenance);

}  // namespace sagitta
