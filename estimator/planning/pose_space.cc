#include "estimator/planning/pose_space.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

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

int IndexOf(const std::vector<std::string>& names, const std::string& name, const char* column) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  throw InputError({"", 0, column}, "the experiment has no " + std::string(column) + " '" + name + "'",
                   SpellingHint(name, names));
}

// What distinguishes one way to measure a configuration from another; not when it was measured.
std::string PatternOf(const Measurements& data, int configuration) {
  std::vector<std::string> shots;
  for (const Shot& shot : data.shots) {
    if (shot.configuration != configuration) continue;
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
    shots.push_back(text);
  }
  std::sort(shots.begin(), shots.end());
  std::string pattern;
  for (const std::string& shot : shots) pattern += shot + ";";
  return pattern;
}

}  // namespace

std::vector<Eigen::VectorXd> PosesInLimits(const Chain& chain, int count, std::uint64_t seed) {
  for (const Joint& joint : chain.joints) {
    if (joint.min && joint.max) continue;
    throw InputError({"", 0, "joints." + joint.name}, "joint '" + joint.name + "' has no limits to draw poses in",
                     "state min_deg and max_deg (prismatic: min_mm and max_mm), or give --candidates=FILE.csv");
  }
  std::mt19937_64 random(seed);
  Eigen::VectorXd shift(chain.num_joints());
  for (double& s : shift) s = static_cast<double>(random() >> 11) * 0x1.0p-53;
  std::vector<Eigen::VectorXd> poses(count, Eigen::VectorXd(chain.num_joints()));
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < chain.num_joints(); ++j) {
      const double turned = RadicalInverse(i + 1, Prime(j)) + shift[j];
      const double share = turned - std::floor(turned);
      poses[i][j] = *chain.joints[j].min + share * (*chain.joints[j].max - *chain.joints[j].min);
    }
  }
  return poses;
}

std::string OutsideLimits(const Chain& chain, const Eigen::VectorXd& q) {
  constexpr double kRounding = 1e-9;  // rad or m: a limit written in degrees
  for (int j = 0; j < chain.num_joints(); ++j) {
    const Joint& joint = chain.joints[j];
    if (joint.min && q[j] < *joint.min - kRounding) return "joint " + joint.name + " is below its limit";
    if (joint.max && q[j] > *joint.max + kRounding) return "joint " + joint.name + " is above its limit";
  }
  return "";
}

ShotPatterns PatternsOf(const Measurements& data, int most) {
  std::map<std::string, std::vector<int>> alike;
  for (size_t c = 0; c < data.configurations.size(); ++c) alike[PatternOf(data, static_cast<int>(c))].push_back(c);
  std::vector<std::vector<int>> groups;
  for (const auto& [pattern, configurations] : alike) groups.push_back(configurations);
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  ShotPatterns patterns;
  for (const std::vector<int>& group : groups) {
    if (static_cast<int>(patterns.configurations.size()) < most) {
      patterns.configurations.push_back(group.front());
    } else {
      ++patterns.left_out;
    }
  }
  return patterns;
}

int AppendConfiguration(const Measurements& from, int configuration, const Eigen::VectorXd& q, const std::string& id,
                        Measurements* to) {
  const int index = static_cast<int>(to->configurations.size());
  Configuration added = from.configurations[configuration];
  if (q.size() > 0) {
    added.q = q;
    added.id = id;
  }
  to->configurations.push_back(added);
  // `from` may be what `to` grows from: by index, and copies.
  const size_t shots = from.shots.size();
  for (size_t s = 0; s < shots; ++s) {
    if (from.shots[s].configuration != configuration) continue;
    Shot shot = from.shots[s];
    const std::vector<int> observations = shot.observations;
    shot.configuration = index;
    shot.station = IndexOf(to->stations, from.stations[shot.station], "station");
    shot.observations.clear();
    const int own = static_cast<int>(to->shots.size());
    std::map<int, int> copy_of;
    for (const int k : observations) {
      Observation row = from.observations[k];
      row.shot = own;
      row.excluded = false;
      row.marker = IndexOf(to->markers, from.markers[row.marker], "marker");
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

std::vector<std::vector<int>> ObservationsByConfiguration(const Measurements& data) {
  std::vector<std::vector<int>> observations(data.configurations.size());
  for (const Shot& shot : data.shots) {
    std::vector<int>& own = observations[shot.configuration];
    own.insert(own.end(), shot.observations.begin(), shot.observations.end());
  }
  return observations;
}

}  // namespace sagitta
