// Target files of `sagitta compensate` (FORMATS section 7): what the flange shall do, one row each.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/robot.h"
#include "problems/io/csv_table.h"
#include "problems/measurements.h"

namespace sagitta {

// Flange pose in the base frame, or the joint values at which the nominal robot has it. SI.
struct Target {
  std::string name;
  std::optional<Eigen::VectorXd> q;  // with a pose: the branch to stay on
  std::optional<Pose<double>> flange_in_base;
};

// Targets as their file lists them, and the shots in which they are to be reached.
struct Targets {
  std::vector<Target> rows;
  std::vector<JointType> joint_types;
  // The same rows as shots of a measurement file without points: station, load, wrench, time, temperature, approach.
  // Configuration, shot and observation i are those of row i; q is 0 where a row states none.
  Measurements shots;
};

// Columns: target, then q1 … qN, or x, y, z (_mm, _m) with rx, ry, rz (_mrad, _rad, _deg, _urad; rotation vector), or
// both; station, load, the wrench, time_s, temperature_degC and approach1 … as in measurement files. A row's pose may
// be empty where it states joint values. `station`: the one of rows that name none. Throws InputError.
Targets ReadTargets(const std::string& path, const Robot& robot, const std::string& station);

// The same of a table that is in memory already.
Targets TargetsFromTable(CsvTable table, const Robot& robot, const std::string& station);

}  // namespace sagitta
