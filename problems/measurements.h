// Measurements as read: rows, and the configurations, visits and shots they form.
//
//   configuration  one commanded joint configuration (column `config`)
//   visit          one arrival at it; latent joint deviations belong to a visit
//   shot           all markers seen at one visit, repeat, load and station
//   observation    one reading of one marker in one shot (models/reading.h): a row of a
//                  file, or, where the row states a pose, its point and its rotation
#pragma once

#include <map>
#include <string>
#include <vector>

#include "models/reading.h"
#include "models/wrench.h"
#include "problems/input_error.h"
#include "problems/measurement_rows.h"

namespace sagitta {

// A file with its cells, so that results can carry every column along.
struct MeasurementFile {
  std::string path;
  std::string sha256;
  std::vector<std::string> header;
  using Row = MeasurementRows::Row;
  MeasurementRows rows;

  int FindColumn(const std::string& name) const;  // -1: none
};

// What a row states of its load, N and N m.
struct Wrench {
  Vector3<double> force = Vector3<double>::Zero();   // N
  Vector3<double> moment = Vector3<double>::Zero();  // N m
  bool IsZero() const { return force.isZero(0.0) && moment.isZero(0.0); }
};

// Joint values that were commanded, and whether they are set aside.
struct Configuration {
  std::string id;
  Eigen::VectorXd q;  // commanded, rad or m, one per joint
  bool is_validation = false;
};

// One look at the arm: a configuration, loaded or not, from one station.
struct Shot {
  int configuration = -1;
  int station = -1;
  std::string visit;
  std::string repeat;
  std::string load = kNoLoad;
  Wrench wrench;
  bool has_time = false;
  double time = 0.0;  // s, mean of its rows
  int campaign = 0;   // with a clock of its own: nothing of another campaign is remembered
  bool has_temperature = false;
  double temperature = 0.0;   // degC, mean of its rows
  std::vector<int> approach;  // -1, 0, +1 per joint, kApproachNotStated where the cell is empty; empty: none is stated
  // Measured, one per joint about its positive direction, N m (N where it slides): mean of the rows that state them;
  // empty: none does.
  Eigen::VectorXd joint_torques;
  std::vector<int> observations;
};

// What is read of a rotation.
struct ObservedRotation {
  Matrix3<double> in_station = Matrix3<double>::Identity();  // station_from_target; NaN where not measured
  Vector3<double> sigma = Vector3<double>::Zero();           // rad, left perturbation; 0: the row states none
};

// One reading of one marker in a shot.
struct Observation {
  int shot = -1;
  int marker = -1;
  Vector3<double> point_in_station = Vector3<double>::Zero();  // m; NaN where the file has no x, y, z
  Vector3<double> sigma = Vector3<double>::Zero();             // m; 0: the row states none
  int file = -1;                                               // index into Measurements::files; -1: of no file
  int row = -1;                                                // index into MeasurementFile::rows
  bool excluded = false;                                       // an outlier: neither fitted nor judged by

  // Of the rotation of a pose: everything above is the row's own, the point included.
  ReadingKind kind = ReadingKind::kPoint;
  int partner = -1;  // the other reading of the same pose; -1: none

  bool is_point() const { return kind == ReadingKind::kPoint; }
  // False: it says where a reading is wanted, or lost.
  bool IsRead() const { return is_point() ? point_in_station.allFinite() : rotation().in_station.allFinite(); }
  const ObservedRotation& rotation() const { return rotations_.empty() ? kNoRotation : rotations_.front(); }
  ObservedRotation* mutable_rotation();
  TargetReading reading() const { return {kind, point_in_station, rotation().in_station}; }
  // What the instrument reads where it should read `exact` (a point, or a rotation vector) and errs by `error`.
  void Read(const Vector3<double>& exact, const Vector3<double>& error);

 private:
  static const ObservedRotation kNoRotation;
  // One, where a rotation is read or its noise is stated. Apart: what walks over all rows, most of which are points,
  // passes half as much memory.
  std::vector<ObservedRotation> rotations_;
};

// All rows, as configurations, shots and observations that refer to each other by index.
struct Measurements {
  // Compiled once (measurements.cc), not in each file that holds one.
  Measurements();
  Measurements(const Measurements&);
  Measurements(Measurements&&) noexcept;
  Measurements& operator=(const Measurements&);
  Measurements& operator=(Measurements&&) noexcept;
  ~Measurements();

  std::vector<MeasurementFile> files;
  std::vector<std::string> stations;  // names, in order of appearance
  std::vector<std::string> markers;
  std::vector<Configuration> configurations;
  std::vector<Shot> shots;
  std::vector<Observation> observations;  // in row order
  std::vector<std::string> warnings;
  std::vector<std::string> unread_columns;  // of any file

  const Configuration& ConfigurationOf(const Observation& observation) const {
    return configurations[shots[observation.shot].configuration];
  }
  // Those of the listed observations that are points: as many as rows.
  std::vector<int> PointsAmong(const std::vector<int>& observations) const;
  int NumRows() const;
  // Of a pose both readings: a target is read well or badly as a whole.
  void ExcludeRow(int observation, bool excluded = true);
  // Of each marker whether a row states its rotation.
  std::vector<bool> OrientedMarkers() const;
  // Adds the rotation of the pose to an observation that is a point, and to the list of its shot. Throws
  // std::invalid_argument where one of these is not there.
  Observation& AddRotation(int point);
  bool IsValidation(const Observation& observation) const { return ConfigurationOf(observation).is_validation; }
  // The cell of an observation's row, "" if its file has no such column or it is of no file.
  std::string Cell(const Observation& observation, const std::string& column) const;
  // "file:line" of an observation; where it is of no file, its configuration and marker in words.
  std::string SourceOf(const Observation& observation) const;
  // The same for an error at a column of the row.
  InputError::Where WhereOf(const Observation& observation, const std::string& column) const;
  // Of a shot: of its first row, or, without rows, its configuration in words.
  InputError::Where WhereOf(const Shot& shot, const std::string& column) const;
};

}  // namespace sagitta
