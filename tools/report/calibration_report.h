// report.html of an estimate: the first screen, then where the rest lies and how well everything is known.
#pragma once

#include <string>
#include <vector>

#include "estimator/sagitta.h"
#include "tools/report/summary.h"

namespace sagitta {

// CalibrationSections with the pictures between them.
std::vector<Section> CalibrationPage(const Calibration& calibration);

std::string CalibrationToHtml(const Calibration& calibration, const Provenance& provenance);
// sections: CalibrationSections of it, where they are at hand.
std::string CalibrationToHtml(const Calibration& calibration, std::vector<Section> sections,
                              const Provenance& provenance);

}  // namespace sagitta
