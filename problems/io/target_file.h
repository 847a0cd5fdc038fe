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

// How a list states the rotation of its poses: one way in a file. Angles a, b, c are those that KUKA's controllers
// write, roll, pitch and yaw turn about fixed axes x, y, z:
//
//   R = Rz(a) Ry(b) Rx(c),    R = Rz(yaw) Ry(pitch) Rx(roll)
enum class RotationForm { kVector, kQuaternion, kAbc, kRollPitchYaw };

// Targets as their file lists them, and the shots in which they are to be reached.
struct Targets {
  std::vector<Target> rows;
  std::vector<JointType> joint_types;
  // The same rows as shots of a measurement file without points: station, load, wrench, time, temperature, approach.
  // Configuration, shot and observation i are those of row i; q is 0 where a row states none
  // (the value of a joint that has only one).
  Measurements shots;
  RotationForm rotation_form = RotationForm::kVector;
  // rx, ry and rz are in degrees and turn about more than one axis: angles of a controller under these names would be
  // read as a vector, without any sign of it.
  bool may_be_no_vector = false;
  std::vector<std::string> notes;  // what the list states otherwise than target files do, in words
};

// Columns: target, then q1 … qN, or x, y, z (_mm, _m) with a rotation, or both. A rotation is rx, ry, rz (_mrad, _rad,
// _deg, _urad; rotation vector), ow, ox, oy, oz or qw, qx, qy, qz (unit quaternion, scalar first), a, b, c or roll,
// pitch, yaw (in the units of rx). station, load, the wrench, time_s, temperature_degC and approach1 … as in
// measurement files. A row's pose may be empty where it states joint values. Lists as spreadsheets and controllers
// write them are read too (import/target_table.h). `station`: the one of rows that name none. Throws InputError.
Targets ReadTargets(const std::string& path, const Robot& robot, const std::string& station);

// The same of a table that is in memory already.
Targets TargetsFromTable(CsvTable table, const Robot& robot, const std::string& station);

}  // namespace sagitta
