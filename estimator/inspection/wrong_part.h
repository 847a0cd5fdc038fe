// A part of the rows that was read in another way than the others: a station in metres or mirrored, markers exchanged
// or points a row late from some shot on. What the file as a whole is asked (readings.h), each part is asked alone
// where the others fit as a robot's rows do:
//
//   stations, or markers, that the nominal robot misses although it fits the others,
//   rows that are far off (wild_rows.h), or off what a beginning or an end of a station fits.
//
// Places that the others see stay where these put them; only those of the part alone are fitted to it. A reading is
// what was meant where the part then fits as the others do.
#pragma once

#include <optional>
#include <vector>

#include "estimator/inspection/finding.h"
#include "estimator/inspection/wild_rows.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct WrongPart {
  Finding finding;
  std::vector<int> rows;  // observations; empty: of whole stations or markers
};

// Nothing where no part alone is the cause. far: rows that are off, where these are known.
std::optional<WrongPart> FindWrongPart(const CalibrationProblem& problem, const std::optional<FarRows>& far);
// Of the rows that are far off alone.
std::optional<WrongPart> FindWrongRows(const CalibrationProblem& problem, const FarRows& far);

}  // namespace sagitta
