// report.html of a validation: how far the calibrated and the nominal robot are from points that were not used in the
// fit.
#pragma once

#include <string>
#include <vector>

#include "estimator/sagitta.h"
#include "tools/report/summary.h"

namespace sagitta {

// validation: of `known` on `rows`. For the terminal; the page has pictures in addition.
std::vector<Section> ValidationSections(const KnownRobot& known, const Measurements& rows,
                                        const Validation& validation);
std::string ValidationToHtml(const KnownRobot& known, const Measurements& rows, const Validation& validation,
                             const Provenance& provenance);

}  // namespace sagitta
