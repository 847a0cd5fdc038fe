// Numbers in another unit than their column says: the nominal robot then misses
// the measured points by far, and fits once the numbers are read in the right one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Of the reach, RMS distance of the aligned nominal robot, beyond which it did not make the readings: ten times what no
// arm needs (reading_lint.cc), and far below the some tenths that numbers in a wrong unit leave.
constexpr double kNotThisRobot = 0.05;

struct UnitFinding {
  std::string file;
  int line = 0;        // of the first row
  std::string column;  // the first one concerned
  std::string words;
  std::string hint;
};

// Radians in _deg columns, degrees in _rad, metres in _mm, millimetres in _m.
// Nothing when the aligned nominal robot is within 5 % of its reach, or when no
// other reading is at least ten times better. Points of other columns than
// x_mm, y_mm, z_mm say which: `point_prefix`, as in sim_x_mm; joints are then
// assumed to be right, and the hint is to convert the numbers.
std::optional<UnitFinding> GuessWrongUnit(const CalibrationProblem& problem, const AlignedSample& aligned,
                                          const std::string& point_prefix = "");
// The same of what is not aligned yet.
std::optional<UnitFinding> GuessWrongUnit(const CalibrationProblem& problem, const std::string& point_prefix = "");

// Throws InputError where GuessWrongUnit finds one.
void CheckUnits(const CalibrationProblem& problem, const AlignedSample& aligned);

// A warning where a link's length is corrected by more than a tenth and 5 mm. "": none.
std::string WarningOfLargeCorrections(const CalibrationProblem& problem, const std::vector<ParameterEstimate>& table);

// A warning where even the estimate misses by more than 1 % of the reach: signs,
// zero positions, kinematics or units do not belong to these data. "": none.
std::string WarningOfMisfit(const CalibrationProblem& problem, double distance_rms);

}  // namespace sagitta
