// Which reading of a foreign table the robot can have made: columns and units, what its angles mean, the convention of
// a DH table. The nominal robot is aligned with the points, and the reading that alone fits is chosen.
#pragma once

#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "problems/io/import/import_plan.h"
#include "problems/io/import/robot_reading.h"
#include "problems/measurements.h"

namespace sagitta {

// The best of several readings has to fit so much better than any other: half a decade, a choice.
constexpr double kBetter = 3.0;

// What is done where no plan fits all rows.
enum class IfNoneFits {
  kRefuse,
  kTryMost,  // the robot is compared with most rows: some may be far off
  kSayWhy    // the same, and where that fails it is inspected for the reason, as calibrate does
};

struct Choice {
  ImportPlan plan;
  double misfit = std::numeric_limits<double>::infinity();           // m, of the aligned nominal robot, RMS
  bool misfit_is_of_most = false;                                    // rows that are far off left out
  double rotation_misfit = std::numeric_limits<double>::infinity();  // rad; infinite where no rotation is used
};

// "0.123 deg".
std::string InDegrees(double radians);

std::set<std::string> LoadsOf(const Measurements& data);

// Of several plans the one that fits; by the size of the numbers where there are too few rows to decide. Throws
// InputError where none fits, or two, and where rows of one marker and pose lie apart by more than any calibration
// explains.
Choice ChoosePlan(const Robot& robot, const TextTable& table, const std::vector<ImportPlan>& plans, IfNoneFits policy);

// Readings that were joined with poses in their order alone: throws InputError where they would fit the robot in
// another order about as well.
void ConfirmOrder(const Robot& robot, const TextTable& table, const Choice& choice);

// Adds the rotation's columns to the plan, or leaves them out with the reason. `stated`: what --rotation says.
// Throws InputError where what the user said does not fit.
void DecideRotation(const Robot& robot, const TextTable& table, const std::string& stated, Choice* choice);

// Positions that the nominal robot reproduces, as far as the digits of the table go, were computed from its joints: an
// InputError, unless the user names the columns.
void RefuseComputedPoints(const Robot& robot, const TextTable& table, const Choice& choice, bool is_mapped);

// The robot of a file; of a DH table that does not say its convention the one with which it can have made the readings.
RobotReading ReadRobotWithReadings(const std::string& path, const RobotReadOptions& options, const TextTable& table,
                                   const std::map<std::string, std::string>& columns);

}  // namespace sagitta
