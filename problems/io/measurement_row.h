// One row of a measurement file, in SI.
#pragma once

#include <string_view>
#include <vector>

#include "problems/io/measurement_columns.h"
#include "problems/io/measurement_file.h"
#include "problems/measurements.h"

namespace sagitta {

// Of a quaternion's length from 1: numbers of three digits, nothing that was scaled.
inline constexpr double kUnitQuaternion = 5e-3;

struct MeasurementRow {
  bool lost = false;  // points are required and x, y, z are all empty; nothing else of the row is read
  std::string_view config, marker, station, visit, repeat, load;  // in the memory of the file's rows
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

// What was read of a column last: rows of a shot repeat joint values and forces to the letter.
struct NumberRead {
  std::string_view text;
  double si = 0.0;
};

// Reads rows of one file, which must outlive it and what it reads.
class MeasurementRowReader {
 public:
  MeasurementRowReader(const MeasurementFile& file, const MeasurementColumns& columns,
                       const MeasurementReadOptions& options)
      : file_(file), columns_(columns), options_(options), last_(file.header.size()) {}

  // Throws InputError naming file, line and column.
  void Read(const MeasurementFile::Row& cells, MeasurementRow* row);

 private:
  const MeasurementFile& file_;
  const MeasurementColumns& columns_;
  const MeasurementReadOptions options_;
  std::vector<NumberRead> last_;  // of each column
};

}  // namespace sagitta
