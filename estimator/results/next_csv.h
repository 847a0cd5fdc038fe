// next.csv of a diagnosis (FORMATS section 6).
#pragma once

#include <string>

#include "estimator/diagnosis/diagnose.h"

namespace sagitta {

// The proposed poses (Diagnosis::next) as a measurement file to fill in: the columns of the first one, rows of the
// configurations that they are like. Their names go on after those of the data, and the split fits them
// (problems/split.h).
std::string NextToCsv(const Diagnosis& diagnosis);

}  // namespace sagitta
