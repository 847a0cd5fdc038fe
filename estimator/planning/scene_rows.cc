#include "estimator/planning/scene_rows.h"

#include <algorithm>
#include <cmath>

#include "estimator/planning/pose_space.h"

namespace sagitta {
namespace {

bool AddNames(const std::vector<std::string>& names, std::vector<std::string>* known) {
  bool any = false;
  for (const std::string& name : names) {
    if (std::find(known->begin(), known->end(), name) != known->end()) continue;
    known->push_back(name);
    any = true;
  }
  return any;
}

}  // namespace

void RowSigmas::Sum::Add(const Vector3<double>& sigma) {
  squares += sigma.cwiseAbs2();
  ++rows;
}

Vector3<double> RowSigmas::Sum::Rms() const { return (squares / std::max(1, rows)).cwiseSqrt(); }

RowSigmas::RowSigmas(const Measurements& data) {
  for (const Observation& row : data.observations) {
    if (!row.is_point() || row.sigma.isZero(0.0) || data.IsValidation(row)) continue;
    of_sight_[{data.stations[data.shots[row.shot].station], data.markers[row.marker]}].Add(row.sigma);
    all_.Add(row.sigma);
  }
}

Vector3<double> RowSigmas::Of(const std::string& station, const std::string& marker) const {
  const auto own = of_sight_.find({station, marker});
  return own != of_sight_.end() ? own->second.Rms() : all_.Rms();
}

SceneRows::SceneRows(const Measurements& data, const NoiseSpec& noise)
    : rows(data), sigmas_(data), one_for_all_(noise.sigma.has_value()) {}

int SceneRows::Add(const Measurements& from, int configuration, const std::vector<int>& shots, const Eigen::VectorXd& q,
                   const std::string& id, const std::vector<int>& approach) {
  const size_t first = rows.shots.size();
  const int added = AppendConfiguration(from, configuration, shots, q, id, &rows);
  if (!approach.empty()) {
    for (size_t s = first; s < rows.shots.size(); ++s) rows.shots[s].approach = approach;
  }
  return added;
}

std::vector<int> SceneRows::AddAll(const Measurements& from, const std::vector<int>& configurations) {
  const int files = static_cast<int>(rows.files.size());
  const size_t first = rows.observations.size();
  rows.files.insert(rows.files.end(), from.files.begin(), from.files.end());
  const std::vector<std::vector<int>> shots = ShotsByConfiguration(from);
  std::vector<int> added;
  for (const int c : configurations) added.push_back(Add(from, c, shots[c], {}, "", {}));
  for (size_t k = first; k < rows.observations.size(); ++k) {
    if (rows.observations[k].file >= 0) rows.observations[k].file += files;
  }
  return added;
}

int SceneRows::FillSigmas(size_t first) {
  if (one_for_all_ || !sigmas_.AnyStated()) return 0;
  int filled = 0;
  for (size_t k = first; k < rows.observations.size(); ++k) {
    Observation& row = rows.observations[k];
    if (!row.is_point() || !row.sigma.isZero(0.0)) continue;
    row.sigma = sigmas_.Of(rows.stations[rows.shots[row.shot].station], rows.markers[row.marker]);
    ++filled;
  }
  return filled;
}

std::vector<int> SceneRows::AddCandidates(const Measurements& from, const std::vector<int>& configurations) {
  const size_t first = rows.observations.size();
  const std::vector<int> added = AddAll(from, configurations);
  without_sigma_ += FillSigmas(first);
  return added;
}

std::vector<int> SceneRows::AddTests(const Measurements& from) {
  std::vector<int> configurations;
  for (size_t c = 0; c < from.configurations.size(); ++c) configurations.push_back(static_cast<int>(c));
  const size_t first = rows.observations.size();
  const std::vector<int> added = AddAll(from, configurations);
  FillSigmas(first);
  if (one_for_all_ || sigmas_.AnyStated()) return added;
  // Of rows none of which states its noise one that does would make the others' missing.
  const auto states = [](const Observation& row) { return row.is_point() && !row.sigma.isZero(0.0); };
  if (std::any_of(rows.observations.begin(), rows.observations.begin() + static_cast<long>(first), states))
    return added;
  for (size_t k = first; k < rows.observations.size(); ++k) rows.observations[k].sigma.setZero();
  return added;
}

bool SceneRows::AddNamesOf(const Measurements& tests) {
  const bool any_station = AddNames(tests.stations, &rows.stations);
  return AddNames(tests.markers, &rows.markers) || any_station;
}

}  // namespace sagitta
