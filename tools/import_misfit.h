// How far the nominal robot, aligned, misses the points of a foreign table: whether it can have made them, and whether
// it did, as a controller that computes them does.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "models/robot.h"
#include "problems/calibration_problem.h"
#include "problems/experiment.h"
#include "problems/io/import/import_plan.h"
#include "problems/io/import/imported_rows.h"
#include "problems/measurements.h"

namespace sagitta {

// Markers that --on has on something else than the flange, by name. Throws InputError where it cannot be read.
std::map<std::string, MarkerSpec> MarkersFromFlags();

// The readings with the robot's geometry alone, markers where --on has them. What loads weigh and where they hang
// stands in no table, nor does much of what the effects of a robot file need (times, sides of approach, a load): both
// move points by millimetres, much less than the misfit of another robot (kNotThisRobot). Throws InputError.
CalibrationProblem ProblemOfGeometry(const Robot& robot, const Measurements& data);

// Of rows that are measurements; InputError where they are none, at the row as it was given.
Measurements CheckedMeasurements(const Robot& robot, const ImportedRows& rows, const std::string& csv);

// A sample of the table's rows, spread over it, as measurements: a reading that is wrong shows in any ten.
Measurements SampleOfTable(const Robot& robot, const TextTable& table, const ImportPlan& plan);

// m, RMS of distances on a sample of the rows; infinite where that cannot be said.
double MisfitOf(const Robot& robot, const TextTable& table, const ImportPlan& plan);

// Throws InputError where it cannot be said although the rows are enough: what is wrong with them or with the robot.
void CheckComparable(const Robot& robot, const TextTable& table, const ImportPlan& plan);

// The same without the rows that are far off, m. Nothing: there are none, or many, or the others do not fit as those of
// one robot do.
std::optional<double> MisfitOfMost(const Robot& robot, const TextTable& table, const ImportPlan& plan);

// Readings that the aligned nominal robot misses by more than any arm needs to be calibrated, and by ten times what it
// misses the others by: points that are lost, rows of means, a reflector that was changed.
struct ReadingsFarOff {
  std::vector<int> rows;          // of the measurements' file, from 0
  std::vector<double> distances;  // m, of each
  double others = 0.0;            // m, RMS of the distances of all others
  size_t all = 0;                 // readings
};
// Nothing: there are none, or they are many, or nothing can be said.
std::optional<ReadingsFarOff> FindReadingsFarOff(const Robot& robot, const Measurements& data);

// m, RMS distance of the points from their mean: what any robot misses them by that holds still.
double SpreadOfPoints(const TextTable& table, const ImportPlan& plan);

// m, how far the aligned nominal robot misses its own points (RMS of distances) where these and the joint values they
// were computed from are rounded to the digits that the table has. Infinite where nothing can be said.
double MisfitOfRounding(const Robot& robot, const TextTable& table, const ImportPlan& plan);

}  // namespace sagitta
