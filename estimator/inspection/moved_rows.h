// Rows of one station that fit up to one of them, and not from there on: an instrument (or the robot's foot) that moved
// by more than a calibration can absorb, tables of two stations put into one.
//
// Of rows in the order of measurement that are one block up to the move and another after it, one half is of one block
// alone. Base poses and markers are aligned to each half; where one fits as a robot's rows do, the block reaches as far
// as the rows fit. How the others fit, other_label.h finds.
#pragma once

#include <optional>

#include "estimator/inspection/wild_rows.h"

namespace sagitta {

// Nothing where no station's rows are two such blocks. `near` and `far` are those of the station.
std::optional<FarRows> FindMovedRows(const CalibrationProblem& problem);

// Rows in the order of measurement: by time where every shot has one, else as they stand in the files.
std::vector<int> InOrderOfMeasurement(const Measurements& data, std::vector<int> rows);

}  // namespace sagitta
