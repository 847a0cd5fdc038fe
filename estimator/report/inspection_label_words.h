// What is said of rows under another label, and of points that are all one.
#pragma once

#include "estimator/inspection/other_label.h"

namespace sagitta {

// spread: RMS distance from their mean, m.
Finding OnePointInWords(double spread);
Finding OtherLabelInWords(const CalibrationProblem& problem, const OtherLabel& found);

}  // namespace sagitta
