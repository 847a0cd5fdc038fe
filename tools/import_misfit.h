// How far the nominal robot, aligned, misses the points of a foreign table: whether it can have made them, and whether
// it did, as a controller that computes them does.
#pragma once

#include "models/robot.h"
#include "problems/experiment.h"
#include "problems/io/import/import_plan.h"
#include "problems/measurements.h"

namespace sagitta {

// What loads weigh and where they hang stands in no table; they bend an arm by millimetres, much less than the misfit
// of another robot (kNotThisRobot).
Experiment WithWeightlessLoads(const Measurements& data);

// A sample of the table's rows, spread over it, as measurements: a reading that is wrong shows in any ten.
Measurements SampleOfTable(const Robot& robot, const TextTable& table, const ImportPlan& plan);

// m, RMS of distances on a sample of the rows; infinite where that cannot be said.
double MisfitOf(const Robot& robot, const TextTable& table, const ImportPlan& plan);

// m, how far the aligned nominal robot misses its own points (RMS of distances) where these and the joint values they
// were computed from are rounded to the digits that the table has. Infinite where nothing can be said.
double MisfitOfRounding(const Robot& robot, const TextTable& table, const ImportPlan& plan);

}  // namespace sagitta
