#include "problems/measurements.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace sagitta {

Measurements::Measurements() = default;
Measurements::Measurements(const Measurements&) = default;
Measurements::Measurements(Measurements&&) noexcept = default;
Measurements& Measurements::operator=(const Measurements&) = default;
Measurements& Measurements::operator=(Measurements&&) noexcept = default;
Measurements::~Measurements() = default;

int MeasurementFile::FindColumn(const std::string& name) const {
  const auto found = std::find(header.begin(), header.end(), name);
  return found == header.end() ? -1 : static_cast<int>(found - header.begin());
}

const ObservedRotation Observation::kNoRotation;

ObservedRotation* Observation::mutable_rotation() {
  if (rotations_.empty()) rotations_.resize(1);
  return &rotations_.front();
}

void Observation::Read(const Vector3<double>& exact, const Vector3<double>& error) {
  if (is_point()) {
    point_in_station = exact + error;
  } else {
    mutable_rotation()->in_station = RotationFromVector(error) * RotationFromVector(exact);
  }
}

std::vector<int> Measurements::PointsAmong(const std::vector<int>& listed) const {
  std::vector<int> points;
  for (const int i : listed) {
    if (observations[i].is_point()) points.push_back(i);
  }
  return points;
}

void Measurements::ExcludeRow(int observation, bool excluded) {
  observations[observation].excluded = excluded;
  const int partner = observations[observation].partner;
  if (partner >= 0) observations[partner].excluded = excluded;
}

int Measurements::NumRows() const {
  return static_cast<int>(std::count_if(observations.begin(), observations.end(),
                                        [](const Observation& observation) { return observation.is_point(); }));
}

std::vector<bool> Measurements::OrientedMarkers() const {
  std::vector<bool> oriented(markers.size(), false);
  for (const Observation& observation : observations) {
    if (!observation.is_point()) oriented[observation.marker] = true;
  }
  return oriented;
}

Observation& Measurements::AddRotation(int point) {
  const int index = static_cast<int>(observations.size());
  if (point < 0 || point >= index) {
    throw std::invalid_argument("AddRotation: there is no observation " + std::to_string(point));
  }
  const int shot = observations[point].shot;
  if (shot < 0 || shot >= static_cast<int>(shots.size())) {
    throw std::invalid_argument("AddRotation: the shot of observation " + std::to_string(point) +
                                " is not there, add it to `shots` first");
  }
  Observation rotation = observations[point];
  rotation.kind = ReadingKind::kRotation;
  rotation.partner = point;
  observations[point].partner = index;
  shots[rotation.shot].observations.push_back(index);
  observations.push_back(rotation);
  return observations.back();
}

std::string Measurements::Cell(const Observation& observation, const std::string& column) const {
  if (observation.file < 0) return "";
  const MeasurementFile& file = files[observation.file];
  const int index = file.FindColumn(column);
  return index < 0 ? "" : std::string(file.rows[observation.row].cells[index]);
}

namespace {

// What distinguishes rows that no file numbers.
std::string InMemory(const Measurements& data, const Shot& shot) {
  std::string words = "configuration " + data.configurations[shot.configuration].id;
  if (!shot.visit.empty()) words += ", visit " + shot.visit;
  if (!shot.repeat.empty()) words += ", repeat " + shot.repeat;
  if (shot.load != kNoLoad) words += ", load " + shot.load;
  if (data.stations.size() > 1) words += ", station " + data.stations[shot.station];
  return words;
}

}  // namespace

std::string Measurements::SourceOf(const Observation& observation) const {
  if (observation.file < 0) {
    const std::string marker = observation.marker < 0 ? "" : ", marker " + markers[observation.marker];
    return InMemory(*this, shots[observation.shot]) + marker;
  }
  const MeasurementFile& file = files[observation.file];
  return file.path + ":" + std::to_string(file.rows.LineOf(observation.row));
}

InputError::Where Measurements::WhereOf(const Observation& observation, const std::string& column) const {
  if (observation.file < 0) return {SourceOf(observation), 0, column};
  const MeasurementFile& file = files[observation.file];
  return {file.path, file.rows.LineOf(observation.row), column};
}

InputError::Where Measurements::WhereOf(const Shot& shot, const std::string& column) const {
  if (shot.observations.empty()) return {InMemory(*this, shot), 0, column};
  return WhereOf(observations[shot.observations.front()], column);
}

}  // namespace sagitta
