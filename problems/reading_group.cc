#include "problems/reading_group.h"

#include <algorithm>

#include "models/matrix_functions.h"
#include "problems/calibration_problem.h"
#include "problems/choices.h"
#include "problems/noise_model.h"

namespace sagitta {
namespace {

using Kind = ReadingGroup::Kind;

constexpr int kFewestCoordinates = 20;  // of a group and of all others: its factor is known to a sixth, 1 / sqrt(40)
const std::vector<std::string> kAxesOfGroups = {"x", "y", "z"};

std::vector<ReadingGroup> AllGroups(const Measurements& data) {
  std::vector<ReadingGroup> groups;
  for (size_t s = 0; s < data.stations.size(); ++s) groups.push_back({Kind::kStation, static_cast<int>(s)});
  for (size_t m = 0; m < data.markers.size(); ++m) groups.push_back({Kind::kMarker, static_cast<int>(m)});
  groups.push_back({Kind::kRotations, 0});
  for (int axis = 0; axis < 3; ++axis) groups.push_back({Kind::kAxis, axis});
  groups.push_back({Kind::kSight, 0});
  return groups;
}

// Names among which a group's index counts.
std::vector<std::string> NamesOf(Kind kind, const Measurements& data) {
  switch (kind) {
    case Kind::kStation:
      return data.stations;
    case Kind::kMarker:
      return data.markers;
    case Kind::kAxis:
      return kAxesOfGroups;
    case Kind::kRotations:
    case Kind::kSight:
      break;
  }
  return {""};
}

bool Has(const ReadingGroup& group, const ReadingWithRoot& reading) {
  if (reading.observation.is_point() == (group.kind == Kind::kRotations)) return false;
  switch (group.kind) {
    case Kind::kStation:
      return reading.data.shots[reading.observation.shot].station == group.index;
    case Kind::kMarker:
      return reading.observation.marker == group.index;
    case Kind::kRotations:
    case Kind::kAxis:
    case Kind::kSight:
      break;
  }
  return true;
}

// Of all points; zero: it has none.
Vector3<double> DirectionOf(const ReadingGroup& group, const ReadingWithRoot& reading) {
  if (group.kind == Kind::kAxis) return Vector3<double>::Unit(group.index);
  const std::string& station = reading.data.stations[reading.data.shots[reading.observation.shot].station];
  return reading.point - InstrumentPlace(reading.experiment, station);
}

}  // namespace

std::string WordOf(Kind kind) {
  switch (kind) {
    case Kind::kStation:
      return "station";
    case Kind::kMarker:
      return "marker";
    case Kind::kRotations:
      return "rotations";
    case Kind::kAxis:
      return "axis";
    case Kind::kSight:
      return "sight";
  }
  return "";
}

std::string NameOf(const ReadingGroup& group, const Measurements& data) {
  return NamesOf(group.kind, data)[static_cast<size_t>(group.index)];
}

std::optional<ReadingGroup> FindGroup(const std::string& kind, const std::string& name, const Measurements& data) {
  const std::optional<Kind> of = FindChoice<Kind>(kind);
  if (!of) return std::nullopt;
  const std::vector<std::string> names = NamesOf(*of, data);
  const auto own = std::find(names.begin(), names.end(), name);
  if (own == names.end()) return std::nullopt;
  return ReadingGroup{*of, static_cast<int>(own - names.begin())};
}

std::vector<ReadingGroup> GroupsOfReadings(const CalibrationProblem& problem) {
  const std::vector<int> rows = problem.CalibrationObservations();
  const std::vector<ReadingGroup> all = AllGroups(problem.data());
  std::vector<long> own(all.size(), 0);
  for (const int i : rows) {
    const ReadingWithRoot reading = ReadingOf(problem, i);
    for (size_t g = 0; g < all.size(); ++g) own[g] += DirectionsOf(reading, all[g]).cols();
  }
  std::vector<ReadingGroup> groups;
  for (size_t g = 0; g < all.size(); ++g) {
    const long others = 3 * static_cast<long>(rows.size()) - own[g];
    if (std::min(own[g], others) >= kFewestCoordinates) groups.push_back(all[g]);
  }
  return groups;
}

Directions DirectionsOf(const ReadingWithRoot& reading, const ReadingGroup& group) {
  if (!Has(group, reading) || !IsStated(reading.root)) return Directions(3, 0);
  if (!group.IsDirection()) return Matrix3<double>::Identity();
  const Vector3<double> whitened = reading.root.inverse() * DirectionOf(group, reading);
  const double length = whitened.norm();
  return length > 0.0 ? Directions(whitened / length) : Directions(3, 0);
}

Matrix3<double> ScalingOf(const ReadingWithRoot& reading, const std::vector<ScaledGroup>& groups) {
  Matrix3<double> scaling = Matrix3<double>::Identity();
  for (const ScaledGroup& scaled : groups) {
    const Directions own = DirectionsOf(reading, scaled.group);
    scaling += (scaled.factor - 1.0) * scaling * own * own.transpose();
  }
  return scaling;
}

Matrix3<double> ScaledRoot(const ReadingWithRoot& reading, const std::vector<ScaledGroup>& groups) {
  const Matrix3<double> scaling = ScalingOf(reading, groups);
  if (scaling.isIdentity(0.0)) return reading.root;
  const Matrix3<double> root = reading.root * scaling;
  return LowerRoot(root * root.transpose());
}

ReadingWithRoot ReadingOf(const CalibrationProblem& problem, int observation) {
  const Observation& row = problem.data().observations[observation];
  return {problem.experiment(), problem.data(), row, row.point_in_station, problem.SqrtCovariance(observation)};
}

CalibrationProblem WithRoots(const CalibrationProblem& problem, const std::function<Matrix3<double>(int)>& root_of) {
  CalibrationProblem with = problem;
  with.resolved_noise.resize(problem.data().observations.size());
  for (size_t i = 0; i < with.resolved_noise.size(); ++i) with.resolved_noise[i] = root_of(static_cast<int>(i));
  return with;
}

CalibrationProblem WithScaledGroups(const CalibrationProblem& problem, const std::vector<ScaledGroup>& groups) {
  CalibrationProblem scaled = WithRoots(problem, [&](int i) { return ScaledRoot(ReadingOf(problem, i), groups); });
  scaled.scaled_groups = groups;
  return scaled;
}

}  // namespace sagitta
