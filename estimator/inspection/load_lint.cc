#include "estimator/inspection/load_lint.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>

#include "estimator/inspection/load_direction.h"
#include "models/quantiles.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr double kSoftest = 1e-3;        // m/N at the flange: 1 N/mm; the lightest arms have ten times more
constexpr double kStiffest = 1e-8;       // m/N: 100 kN/mm, a machine tool
constexpr double kSeenDeflection = 5.0;  // times the noise, where one is stated: their direction is known to 0.2 rad
constexpr double kAgainst = -0.5;        // cosine between force and motion, mean over the pairs: half way to opposite

// Loaded minus unloaded of equal configuration, visit, station and marker, for the loads of one id.
struct Deflections {
  std::vector<double> sizes;      // m
  std::vector<double> per_force;  // m/N
  double cosines = 0.0;           // sum, force against motion
  int directed = 0;               // pairs whose force is stated in the frame of the points
  double noise = 0.0;             // m, largest root of a row
  int first_row = -1;             // observation
};

using Key = std::tuple<int, std::string, int, int>;

Key KeyOf(const Shot& shot, const Observation& row) {
  return {shot.configuration, shot.visit, shot.station, row.marker};
}

void AddPair(const CalibrationProblem& problem, int loaded, const Vector3<double>& unloaded, Deflections* all) {
  const Observation& row = problem.data().observations[loaded];
  const std::vector<AppliedWrench>& wrenches = problem.shot_inputs()[row.shot].conditions.load_wrenches;
  if (wrenches.empty() || wrenches.front().force.norm() == 0.0) return;
  const AppliedWrench& wrench = wrenches.front();
  const Vector3<double> moved = row.point_in_station - unloaded;
  if (all->first_row < 0) all->first_row = loaded;
  all->sizes.push_back(moved.norm());
  all->per_force.push_back(moved.norm() / wrench.force.norm());
  all->noise = std::max(all->noise, problem.SqrtCovariance(loaded).norm());
  if (wrench.expressed_in != WrenchFrame::kMeasurement || moved.norm() == 0.0) return;
  all->cosines += moved.dot(wrench.force) / (moved.norm() * wrench.force.norm());
  ++all->directed;
}

std::map<std::string, Deflections> CollectDeflections(const CalibrationProblem& problem) {
  const Measurements& data = problem.data();
  std::map<Key, Vector3<double>> unloaded;
  for (const Observation& row : data.observations) {
    if (!IsLoaded(data.shots[row.shot])) unloaded.try_emplace(KeyOf(data.shots[row.shot], row), row.point_in_station);
  }
  std::map<std::string, Deflections> found;
  for (size_t i = 0; i < data.observations.size(); ++i) {
    const Observation& row = data.observations[i];
    const Shot& shot = data.shots[row.shot];
    const auto rest = unloaded.find(KeyOf(shot, row));
    if (!IsLoaded(shot) || rest == unloaded.end() || !row.is_point()) continue;
    AddPair(problem, static_cast<int>(i), rest->second, &found[shot.load]);
  }
  return found;
}

}  // namespace

std::vector<Finding> LintDeflections(const CalibrationProblem& problem) {
  std::vector<Finding> findings;
  bool is_against = false;
  for (const auto& [load, deflections] : CollectDeflections(problem)) {
    if (deflections.sizes.empty()) continue;
    const double size = Median(deflections.sizes), flexibility = Median(deflections.per_force);
    if (size <= kSeenDeflection * deflections.noise) continue;
    const std::vector<std::string> first_row = {
        problem.data().SourceOf(problem.data().observations[deflections.first_row])};
    if (flexibility > kSoftest || flexibility < kStiffest) {
      findings.push_back(Found(Severity::kSerious, "load_unit",
                               LoadUnitIsOff(load, size, flexibility, flexibility > kSoftest), first_row));
    }
    if (deflections.directed > 0 && deflections.cosines < kAgainst * deflections.directed) {
      findings.push_back(Found(Severity::kSerious, "load_sign", LoadSignIsOff(load), first_row));
      is_against = true;
    }
  }
  // Against the force is the other direction, too.
  if (std::optional<Finding> across = is_against ? std::nullopt : LintLoadDirection(problem))
    findings.push_back(std::move(*across));
  return findings;
}

}  // namespace sagitta
