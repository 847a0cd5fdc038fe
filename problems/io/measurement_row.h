// One row of a measurement file, in SI.
#pragma once

#include <string>
#include <vector>

#include "problems/io/measurement_columns.h"
#include "problems/io/measurement_file.h"
#include "problems/measurements.h"

namespace sagitta {

struct MeasurementRow {
  bool lost = false;  // points are required and x, y, z are all empty; nothing else of the row is read
  std::string config, marker, station, visit, repeat, load;
  Eigen::VectorXd q;
  Vector3<double> point = Vector3<double>::Zero();  // NaN where not stated
  Vector3<double> sigma = Vector3<double>::Zero();  // 0 where not stated
  bool is_pose = false;
  Matrix3<double> rotation = Matrix3<double>::Identity();    // station_from_target, of a pose
  Vector3<double> rotation_sigma = Vector3<double>::Zero();  // rad, left perturbation; 0 where not stated
  Wrench wrench;
  bool has_time = false, has_temperature = false;
  double time = 0.0, temperature = 0.0;
  std::vector<int> approach;
  Eigen::VectorXd joint_torques;  // N m or N, one per joint; empty where not stated
};

// Throws InputError naming file, line and column.
void ReadMeasurementRow(const MeasurementFile& file, const MeasurementFile::Row& cells,
                        const MeasurementColumns& columns, const MeasurementReadOptions& options, MeasurementRow* row);

}  // namespace sagitta
