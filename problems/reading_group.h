// Groups of readings whose noise may differ from what is stated by a factor of their own: the readings of a station, of
// a marker, rotations, what is read along one axis or along the line of sight.
//
// Of a reading with the covariance S S' a group has some directions W, orthonormal once the reading is whitened: all
// three or one. With the factor f of the group
//
//   Sigma = S M M' S',   M = I + (f - 1) W W'
//
// adds (f^2 - 1) / (d' (S S')^-1 d) of variance along its direction d, what is known of it given the other two, or
// multiplies S by f. Of several groups M is the product in their order.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "problems/experiment.h"
#include "problems/measurements.h"

namespace sagitta {

class CalibrationProblem;

struct ReadingGroup {
  enum class Kind {
    kStation,    // points of a station
    kMarker,     // points of a marker
    kRotations,  // all rotations
    kAxis,       // all points, along an axis of the frame they are measured in
    kSight       // all points, along the line from the instrument
  };
  Kind kind = Kind::kStation;
  int index = 0;  // of the station, marker or axis

  bool operator==(const ReadingGroup& other) const { return Parts() == other.Parts(); }
  bool operator<(const ReadingGroup& other) const { return Parts() < other.Parts(); }
  // Whether it has one direction of each reading.
  bool IsDirection() const { return kind == Kind::kAxis || kind == Kind::kSight; }

 private:
  std::tuple<Kind, int> Parts() const { return {kind, index}; }
};

// In files: "station" with a name, "marker" with a name, "rotations", "axis" with x, y or z, "sight".
std::string WordOf(ReadingGroup::Kind kind);
std::string NameOf(const ReadingGroup& group, const Measurements& data);  // "" where its kind says all
// The group that a file means; nothing where the data do not have it.
std::optional<ReadingGroup> FindGroup(const std::string& kind, const std::string& name, const Measurements& data);

// Groups of the fitted readings of which a factor can be determined: such that have 20 coordinates (a factor is known
// to a sixth then) and leave as many to others.
std::vector<ReadingGroup> GroupsOfReadings(const CalibrationProblem& problem);

// A group and the factor of its noise.
struct ScaledGroup {
  ReadingGroup group;
  double factor = 1.0;  // of standard deviations
};

// One reading as a noise sees it. point: where it was measured or is predicted, m.
struct ReadingWithRoot {
  const Experiment& experiment;
  const Measurements& data;
  const Observation& observation;
  Vector3<double> point;
  Matrix3<double> root;  // S
};

using Directions = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>;
// W; no columns: the reading is not the group's, or nothing states its noise.
Directions DirectionsOf(const ReadingWithRoot& reading, const ReadingGroup& group);
// M.
Matrix3<double> ScalingOf(const ReadingWithRoot& reading, const std::vector<ScaledGroup>& groups);
// Lower triangular root of S M M' S'; S itself where no group has the reading.
Matrix3<double> ScaledRoot(const ReadingWithRoot& reading, const std::vector<ScaledGroup>& groups);

// An observation of a problem, where it was measured, with its noise.
ReadingWithRoot ReadingOf(const CalibrationProblem& problem, int observation);

// The problem with other roots of the noise of its readings.
CalibrationProblem WithRoots(const CalibrationProblem& problem, const std::function<Matrix3<double>(int)>& root_of);
// The problem with the noise of groups of readings multiplied, of rows to come too.
CalibrationProblem WithScaledGroups(const CalibrationProblem& problem, const std::vector<ScaledGroup>& groups);

}  // namespace sagitta
