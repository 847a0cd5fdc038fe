#include "estimator/planning/scene_rows.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimator/planning/pose_space.h"
#include "estimator/statistics/shuffle.h"
#include "problems/noise_model.h"

namespace sagitta {
namespace {

bool AddUnknownNames(const std::vector<std::string>& names, std::vector<std::string>* known) {
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

MeasuredAlike::Key MeasuredAlike::KeyOf(const Measurements& data, const Observation& row) {
  const Shot& shot = data.shots[row.shot];
  return {data.stations[shot.station], shot.load, data.markers[row.marker], row.is_point()};
}

bool MeasuredAlike::Differs(const Spread& spread) {
  constexpr double kRounding = 1e-9;
  return spread.rows > 0 && spread.largest > spread.least * (1.0 + kRounding);
}

MeasuredAlike::MeasuredAlike(const Measurements& data, const std::vector<int>& configurations,
                             std::optional<double> otherwise) {
  const std::vector<std::vector<int>> shots = ShotsByConfiguration(data);
  std::map<Key, std::pair<Vector3<double>, Vector3<double>>> axes;  // least and largest of each
  for (const int c : configurations) {
    auto& conditions = conditions_.emplace_back();
    for (const int s : shots[c]) {
      const Shot& shot = data.shots[s];
      Shot when;
      when.has_time = shot.has_time;
      when.time = shot.time;
      when.campaign = shot.campaign;
      when.has_temperature = shot.has_temperature;
      when.temperature = shot.temperature;
      conditions[{data.stations[shot.station], shot.load}].push_back(when);
      for (const int k : shot.observations) {
        const Observation& row = data.observations[k];
        Vector3<double> sigma = row.is_point() ? row.sigma : row.rotation().sigma;
        if (sigma.isZero(0.0)) {
          if (!row.is_point())
            sigma.setConstant(kUnstatedRotationSigma);
          else if (otherwise)
            sigma.setConstant(*otherwise);
          else
            continue;
        }
        Spread& spread = spreads_[KeyOf(data, row)];
        auto& [least, largest] = axes.emplace(KeyOf(data, row), std::make_pair(sigma, sigma)).first->second;
        least = least.cwiseMin(sigma);
        largest = largest.cwiseMax(sigma);
        spread.squares += sigma.cwiseAbs2();
        ++spread.rows;
      }
    }
  }
  for (auto& [key, spread] : spreads_) {  // of the axis that differs most
    const auto& [least, largest] = axes.at(key);
    Eigen::Index axis = 0;
    (largest.array() / least.array()).maxCoeff(&axis);
    spread.least = least[axis];
    spread.largest = largest[axis];
  }
}

std::optional<std::pair<double, double>> MeasuredAlike::SigmasThatDiffer() const {
  std::optional<std::pair<double, double>> most;
  for (const auto& [key, spread] : spreads_) {
    if (!std::get<3>(key) || !Differs(spread)) continue;
    if (!most || spread.largest / spread.least > most->second / most->first) most = {spread.least, spread.largest};
  }
  return most;
}

void MeasuredAlike::Complete(size_t number, size_t first, Measurements* rows) const {
  const auto& conditions = conditions_[number];
  std::map<std::pair<std::string, std::string>, size_t> seen;
  for (size_t s = first; s < rows->shots.size(); ++s) {
    Shot& shot = rows->shots[s];
    const std::pair<std::string, std::string> of{rows->stations[shot.station], shot.load};
    const Shot& when = conditions.at(of)[seen[of]++];
    shot.has_time = when.has_time;
    shot.time = when.time;
    shot.campaign = when.campaign;
    shot.has_temperature = when.has_temperature;
    shot.temperature = when.temperature;
    for (const int k : shot.observations) {
      Observation& row = rows->observations[k];
      const auto found = spreads_.find(KeyOf(*rows, row));
      if (found == spreads_.end() || !Differs(found->second)) continue;
      const Vector3<double> rms = (found->second.squares / found->second.rows).cwiseSqrt();
      if (row.is_point())
        row.sigma = rms;
      else
        row.mutable_rotation()->sigma = rms;
    }
  }
}

RandomTurns::RandomTurns(size_t count, std::uint64_t seed) : turns_(count), next_(count), random_(seed) {
  std::iota(turns_.begin(), turns_.end(), size_t{0});
}

size_t RandomTurns::Next() {
  if (next_ == turns_.size()) {
    Shuffle(&turns_, &random_);
    next_ = 0;
  }
  return turns_[next_++];
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
  const bool any_station = AddUnknownNames(tests.stations, &rows.stations);
  return AddUnknownNames(tests.markers, &rows.markers) || any_station;
}

}  // namespace sagitta
