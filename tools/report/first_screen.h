// What an engineer reads first, on the terminal and in report.html alike: one sentence, points that the estimate has
// not seen, what was not measured, suspect rows, model error; then the corrected table as it is typed into a
// controller.
#pragma once

#include <vector>

#include "estimator/sagitta.h"
#include "tools/report/summary.h"

namespace sagitta {

// The first section is the heading.
std::vector<Section> FirstScreen(const Calibration& calibration);
// How many sections that are.
size_t SizeOfFirstScreen(const Calibration& calibration);

// The first ten, one a line; `where`: words on where the others stand, after their number.
Section SuspectRows(const Calibration& calibration, const std::string& where);

// Nominal, correction and calibrated value of every row of the robot's DH table; none for other robots.
std::vector<Section> CorrectedTable(const Calibration& calibration);

// FirstScreen, then all that Summarise says.
std::vector<Section> CalibrationSections(const Calibration& calibration);

}  // namespace sagitta
