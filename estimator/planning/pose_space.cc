#include "estimator/planning/pose_space.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "models/random_bits.h"
#include "problems/input_error.h"

namespace sagitta {
namespace {

// The n-th prime, n from 0.
int Prime(int n) {
  for (int candidate = 2;; ++candidate) {
    bool is_prime = true;
    for (int d = 2; d * d <= candidate; ++d) is_prime = is_prime && candidate % d != 0;
    if (is_prime && n-- == 0) return candidate;
  }
}

// i written in the base, mirrored at the point: 0 to 1.
double RadicalInverse(int i, int base) {
  double value = 0.0, digit = 1.0;
  for (; i > 0; i /= base) value += (digit /= base) * (i % base);
  return value;
}

// where(): of the row that names it.
template <typename Where>
int IndexOf(const std::vector<std::string>& names, const std::string& name, const Where& where) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  const InputError::Where row = where();
  throw InputError(row, "the experiment has no " + row.key + " '" + name + "'", SpellingHint(name, names));
}

// What distinguishes one way to measure a configuration from another, with which of its shots share an arrival; not
// when it was measured, nor how exactly.
std::string PatternOf(const Measurements& data, const std::vector<int>& of_configuration) {
  std::map<std::string, std::vector<std::string>> of_visit;  // its shots
  for (const int s : of_configuration) {
    const Shot& shot = data.shots[s];
    std::vector<std::string> markers;
    for (const int k : shot.observations) {
      const Observation& row = data.observations[k];
      markers.push_back(std::to_string(row.marker) + (row.is_point() ? "p" : "r"));
    }
    std::sort(markers.begin(), markers.end());
    std::string text = std::to_string(shot.station) + "|" + shot.load + "|";
    // To the newton and the newton metre: forces that are measured scatter.
    for (int i = 0; i < 3; ++i) {
      text += std::to_string(std::lround(shot.wrench.force[i])) + "," +
              std::to_string(std::lround(shot.wrench.moment[i])) + "|";
    }
    for (const std::string& marker : markers) text += marker;
    of_visit[shot.visit].push_back(text);
  }
  std::vector<std::string> visits;
  for (auto& [name, shots] : of_visit) {
    std::sort(shots.begin(), shots.end());
    std::string& visit = visits.emplace_back();
    for (const std::string& shot : shots) visit += shot + ";";
  }
  std::sort(visits.begin(), visits.end());
  std::string pattern;
  for (const std::string& visit : visits) pattern += visit + "/";
  return pattern;
}

}  // namespace

std::vector<JointRange> DrawingRanges(const Chain& chain, const Cell* cell) {
  std::vector<JointRange> ranges(chain.num_joints());
  for (int j = 0; j < chain.num_joints(); ++j) {
    const Joint& joint = chain.joints[j];
    JointRange& range = ranges[j];
    if (cell != nullptr) range = cell->joints[j];
    const auto within = [&](double level) {
      return !(joint.min && level < *joint.min) && !(joint.max && level > *joint.max);
    };
    range.levels.erase(std::remove_if(range.levels.begin(), range.levels.end(), [&](double l) { return !within(l); }),
                       range.levels.end());
    if (joint.min) range.min = std::max(*joint.min, range.min.value_or(*joint.min));
    if (joint.max) range.max = std::min(*joint.max, range.max.value_or(*joint.max));
    const bool had_levels = cell != nullptr && !cell->joints[j].levels.empty();
    if ((range.min && range.max && *range.min > *range.max) || (had_levels && range.levels.empty())) {
      throw InputError({cell != nullptr ? cell->file : "", 0, "joints." + joint.name},
                       "the range of joint '" + joint.name + "' in the cell lies outside its limits",
                       "check units and signs");
    }
    if (!range.levels.empty() || (range.min && range.max)) continue;
    throw InputError({"", 0, "joints." + joint.name}, "joint '" + joint.name + "' has no limits to draw poses in",
                     "state min_deg and max_deg (prismatic: min_mm and max_mm), or give --candidates=FILE.csv");
  }
  return ranges;
}

PoseSequence::PoseSequence(std::vector<JointRange> ranges, std::uint64_t seed) : ranges_(std::move(ranges)) {
  std::mt19937_64 random(seed);
  shift_.resize(2 * ranges_.size());
  for (double& s : shift_) s = UnitNumber(random());
}

double PoseSequence::Share(int dimension) const {
  // Halton sequence with a random shift modulo 1 (Cranley and Patterson 1976): even in all joints, another for each
  // seed.
  const double turned = RadicalInverse(drawn_, Prime(dimension)) + shift_[dimension];
  return turned - std::floor(turned);
}

PoseSequence::Drawn PoseSequence::Next() {
  ++drawn_;
  const int n = static_cast<int>(ranges_.size());
  Drawn pose{Eigen::VectorXd(n), std::vector<int>(n)};
  for (int j = 0; j < n; ++j) {
    const JointRange& range = ranges_[j];
    const double share = Share(j);
    if (range.levels.empty()) {
      pose.q[j] = *range.min + share * (*range.max - *range.min);
    } else {
      const size_t level = static_cast<size_t>(share * static_cast<double>(range.levels.size()));
      pose.q[j] = range.levels[std::min(level, range.levels.size() - 1)];
    }
    pose.approach[j] = Share(n + j) < 0.5 ? -1 : 1;
  }
  return pose;
}

ShotPatterns PatternsOf(const Measurements& data, int most) {
  std::map<std::string, std::vector<int>> alike;
  const std::vector<std::vector<int>> shots = ShotsByConfiguration(data);
  for (size_t c = 0; c < data.configurations.size(); ++c) {
    if (!data.configurations[c].is_validation) alike[PatternOf(data, shots[c])].push_back(static_cast<int>(c));
  }
  std::vector<std::vector<int>> groups;
  for (const auto& [pattern, configurations] : alike) groups.push_back(configurations);
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  ShotPatterns patterns;
  for (const std::vector<int>& group : groups) {
    if (static_cast<int>(patterns.configurations.size()) < most) {
      patterns.configurations.push_back(group.front());
      patterns.alike.push_back(group);
    } else {
      ++patterns.left_out;
    }
  }
  return patterns;
}

int AppendConfiguration(const Measurements& from, int configuration, const std::vector<int>& shots,
                        const Eigen::VectorXd& q, const std::string& id, Measurements* to) {
  const int index = static_cast<int>(to->configurations.size());
  Configuration added = from.configurations[configuration];
  const bool is_elsewhere = q.size() > 0;
  if (is_elsewhere) {
    added.q = q;
    added.id = id;
  }
  to->configurations.push_back(added);
  // `from` may be what `to` grows from: by index, and copies.
  for (const int s : shots) {
    Shot shot = from.shots[s];
    const std::vector<int> observations = shot.observations;
    shot.configuration = index;
    shot.station =
        IndexOf(to->stations, from.stations[shot.station], [&] { return from.WhereOf(from.shots[s], "station"); });
    shot.observations.clear();
    const int own = static_cast<int>(to->shots.size());
    std::map<int, int> copy_of;
    for (const int k : observations) {
      Observation row = from.observations[k];
      row.shot = own;
      row.excluded = false;
      row.marker =
          IndexOf(to->markers, from.markers[row.marker], [&] { return from.WhereOf(from.observations[k], "marker"); });
      if (is_elsewhere) row.file = row.row = -1;
      copy_of[k] = static_cast<int>(to->observations.size());
      shot.observations.push_back(copy_of[k]);
      to->observations.push_back(row);
    }
    for (const auto& [original, copy] : copy_of) {
      Observation& row = to->observations[copy];
      if (row.partner >= 0) row.partner = copy_of.at(row.partner);
    }
    to->shots.push_back(shot);
  }
  return index;
}

std::vector<std::vector<int>> ShotsByConfiguration(const Measurements& data) {
  std::vector<std::vector<int>> shots(data.configurations.size());
  for (size_t s = 0; s < data.shots.size(); ++s) shots[data.shots[s].configuration].push_back(static_cast<int>(s));
  return shots;
}

std::vector<std::vector<int>> ObservationsByConfiguration(const Measurements& data) {
  std::vector<std::vector<int>> observations(data.configurations.size());
  for (const Shot& shot : data.shots) {
    std::vector<int>& own = observations[shot.configuration];
    own.insert(own.end(), shot.observations.begin(), shot.observations.end());
  }
  return observations;
}

}  // namespace sagitta
