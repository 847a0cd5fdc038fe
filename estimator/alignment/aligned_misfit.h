// How far the nominal robot misses the measured points at best: base poses and markers fitted to a sample of the
// rows. What tells a wrong unit, sign or convention from a robot that only needs calibration.
#pragma once

#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// Sum of the arm's nominal translations, m: the length that misfits are measured by.
double Reach(const Chain& chain);

// Calibration rows that see every station and marker, at most 40 of each pair.
std::vector<int> SampleOfRows(const CalibrationProblem& problem);

// RMS of the 3-D distances, m, of the aligned nominal robot on these rows.
double AlignedMisfit(const CalibrationProblem& problem, const std::vector<int>& rows);

std::string WholeMillimetres(double metres);

}  // namespace sagitta
