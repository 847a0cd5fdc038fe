#include "problems/noise_model.h"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>

namespace sagitta {

Matrix3<double> InstrumentRoot(const NoiseSpec& noise, const Vector3<double>& point,
                               const Vector3<double>& instrument) {
  const Vector3<double> sight = point - instrument;
  const double distance = sight.norm();
  const double across = noise.angle + noise.angle_per_m * distance;
  const double along = noise.range + noise.range_per_m * distance;
  const Vector3<double> u = distance > 0.0 ? Vector3<double>(sight / distance) : Vector3<double>::UnitX();
  return across * Matrix3<double>::Identity() + (along - across) * u * u.transpose();
}

Vector3<double> InstrumentPlace(const Experiment& experiment, const std::string& station) {
  const auto spec = experiment.stations.find(station);
  if (spec == experiment.stations.end()) return Vector3<double>::Zero();
  return spec->second.instrument_xyz.value_or(Vector3<double>::Zero());
}

Matrix3<double> StatedRoot(const Experiment& experiment, const Measurements& data, const Observation& observation,
                           const Vector3<double>& point) {
  const NoiseSpec& noise = experiment.noise;
  if (noise.from == NoiseSpec::From::kInstrument) {
    return InstrumentRoot(noise, point,
                          InstrumentPlace(experiment, data.stations[data.shots[observation.shot].station]));
  }
  const double otherwise = noise.sigma.value_or(0.0);
  // Equal weights with variance components: one common sigma for all rows, to be found.
  const bool is_common = experiment.weights == "equal" && noise.from == NoiseSpec::From::kVarianceComponents;
  const bool rows_count = !is_common && !noise.replaces_rows;
  const bool row_states = rows_count && observation.sigma.minCoeff() > 0.0;
  return (row_states ? observation.sigma : Vector3<double>::Constant(otherwise).eval()).asDiagonal();
}

bool IsStated(const Matrix3<double>& root) { return root.determinant() > 0.0; }

bool IsDiagonal(const NoiseRoots& roots) {
  return std::all_of(roots.begin(), roots.end(), [](const Matrix3<double>& s) { return s.isDiagonal(1e-9); });
}

std::optional<RepeatScatter> PooledRepeats(const Measurements& data) {
  struct Group {
    Vector3<double> sum = Vector3<double>::Zero();
    std::vector<Vector3<double>> points;
  };
  std::map<std::tuple<int, std::string, int, std::string, int>, Group> groups;
  for (const Observation& observation : data.observations) {
    if (observation.excluded || data.IsValidation(observation)) continue;
    const Shot& shot = data.shots[observation.shot];
    Group& group = groups[{shot.configuration, shot.visit, observation.marker, shot.load, shot.station}];
    group.sum += observation.point_in_station;
    group.points.push_back(observation.point_in_station);
  }
  RepeatScatter scatter;
  Vector3<double> squares = Vector3<double>::Zero();
  for (const auto& [key, group] : groups) {
    const Vector3<double> mean = group.sum / static_cast<double>(group.points.size());
    for (const Vector3<double>& point : group.points) squares += (point - mean).cwiseAbs2();
    scatter.dof += static_cast<int>(group.points.size()) - 1;
  }
  if (scatter.dof == 0) return std::nullopt;
  scatter.sigma = (squares / scatter.dof).cwiseSqrt();
  return scatter;
}

double SigmaDof(const std::optional<RepeatScatter>& repeats) {
  return repeats ? 3.0 * repeats->dof : std::numeric_limits<double>::infinity();
}

}  // namespace sagitta
