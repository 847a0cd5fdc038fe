#include "problems/noise_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
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
  if (!observation.is_point()) {
    Observation of_point = observation;
    of_point.kind = ReadingKind::kPoint;
    if (!IsStated(StatedRoot(experiment, data, of_point, point))) return Matrix3<double>::Zero();
    const bool states = observation.rotation().sigma.minCoeff() > 0.0;
    return (states ? observation.rotation().sigma : Vector3<double>::Constant(kUnstatedRotationSigma).eval())
        .asDiagonal();
  }
  if (noise.from == NoiseSpec::From::kInstrument) {
    const Matrix3<double> root =
        InstrumentRoot(noise, point, InstrumentPlace(experiment, data.stations[data.shots[observation.shot].station]));
    // Exact in a direction, where sigmas that go with the distance have none: nothing can be weighed by that.
    return root.allFinite() && !IsRoot(root) ? Matrix3<double>::Zero().eval() : root;
  }
  const double otherwise = noise.sigma.value_or(0.0);
  // Equal weights with variance components: one common sigma for all rows, to be found.
  const bool is_common =
      experiment.method.weights == Weights::kEqual && noise.from == NoiseSpec::From::kVarianceComponents;
  const bool rows_count = !is_common && !noise.replaces_rows;
  const bool row_states = rows_count && observation.sigma.minCoeff() > 0.0;
  return (row_states ? observation.sigma : Vector3<double>::Constant(otherwise).eval()).asDiagonal();
}

bool IsStated(const Matrix3<double>& root) { return root.allFinite() && !root.isZero(0.0); }

bool IsRoot(const Matrix3<double>& root) {
  constexpr double kAsInverse = 1e-6;  // singular matrices of rounded numbers have an inverse that is none
  const Matrix3<double> inverse = root.inverse();
  return inverse.allFinite() && (root * inverse).isIdentity(kAsInverse);
}

bool IsDiagonal(const NoiseRoots& roots) {
  return std::all_of(roots.begin(), roots.end(), [](const Matrix3<double>& s) { return s.isDiagonal(1e-9); });
}

namespace {

// Each axis by itself, or all three together, as their degrees of freedom allow.
Vector3<double> SpreadOfAxes(const Vector3<double>& squares, int dof_per_axis) {
  if (dof_per_axis >= kLeastSpreadDof) return (squares / dof_per_axis).cwiseSqrt();
  return Vector3<double>::Constant(std::sqrt(squares.sum() / (3.0 * dof_per_axis)));
}

// None where all axes together have too few.
void SetRotationSigma(const Vector3<double>& squares, int dof_per_axis, RepeatScatter* scatter) {
  scatter->rotation_dof = 3.0 * dof_per_axis;
  if (3 * dof_per_axis < kLeastSpreadDof) return;
  scatter->rotation_axes_differ = dof_per_axis >= kLeastSpreadDof;
  scatter->rotation_sigma = SpreadOfAxes(squares, dof_per_axis);
}

void AddSpread(double share, double dof, bool axes_differ, std::vector<KnownSpread>* spreads) {
  const int axes = axes_differ ? 3 : 1;
  spreads->insert(spreads->end(), axes, {share / axes, dof / axes});
}

std::optional<RepeatScatter> PooledAmong(const Measurements& data, bool of_validation) {
  struct Group {
    const Observation* first = nullptr;
    std::vector<Vector3<double>> from_first;  // rotations: angles, small enough to add
  };
  std::map<std::tuple<int, std::string, int, std::string, int, ReadingKind>, Group> groups;
  double readings = 0.0, rotations = 0.0;
  for (const Observation& observation : data.observations) {
    if (observation.excluded || data.IsValidation(observation) != of_validation) continue;
    readings += 1.0;
    rotations += observation.is_point() ? 0.0 : 1.0;
    const Shot& shot = data.shots[observation.shot];
    Group& group =
        groups[{shot.configuration, shot.visit, observation.marker, shot.load, shot.station, observation.kind}];
    if (group.first == nullptr) group.first = &observation;
    const Vector3<double> first =
        observation.is_point() ? group.first->point_in_station : RotationVector(group.first->rotation().in_station);
    group.from_first.push_back(MeasuredMinusPredicted(observation.reading(), first));
  }
  RepeatScatter scatter;
  int rotation_dof = 0;
  Vector3<double> squares = Vector3<double>::Zero(), rotation_squares = squares;
  for (const auto& [key, group] : groups) {
    Vector3<double> mean = Vector3<double>::Zero();
    for (const Vector3<double>& off : group.from_first) mean += off / static_cast<double>(group.from_first.size());
    const bool is_point = std::get<ReadingKind>(key) == ReadingKind::kPoint;
    for (const Vector3<double>& off : group.from_first) {
      (is_point ? squares : rotation_squares) += (off - mean).cwiseAbs2();
    }
    (is_point ? scatter.dof : rotation_dof) += static_cast<int>(group.from_first.size()) - 1;
  }
  if (scatter.dof == 0) return std::nullopt;
  scatter.axes_differ = scatter.dof >= kLeastSpreadDof;
  scatter.sigma = SpreadOfAxes(squares, scatter.dof);
  scatter.rotation_share = rotations / std::max(1.0, readings);
  SetRotationSigma(rotation_squares, rotation_dof, &scatter);
  scatter.is_of_fitted = !of_validation;
  return scatter;
}

}  // namespace

std::optional<RepeatScatter> PooledRepeats(const Measurements& data) {
  const std::optional<RepeatScatter> of_fitted = PooledAmong(data, false);
  return of_fitted ? of_fitted : PooledAmong(data, true);
}

std::vector<KnownSpread> SpreadsOf(const RepeatScatter& repeats) {
  std::vector<KnownSpread> spreads;
  AddSpread(1.0 - repeats.rotation_share, 3.0 * repeats.dof, repeats.axes_differ, &spreads);
  // A spread of residuals makes their squares what they are: nothing of these scatters with it.
  if (!(repeats.rotation_sigma.minCoeff() > 0.0) || repeats.rotation_is_estimated) return spreads;
  AddSpread(repeats.rotation_share, repeats.rotation_dof, repeats.rotation_axes_differ, &spreads);
  return spreads;
}

double SigmaDof(const std::optional<RepeatScatter>& repeats) {
  if (!repeats) return std::numeric_limits<double>::infinity();
  double inverse = 0.0;
  for (const KnownSpread& spread : SpreadsOf(*repeats)) inverse += spread.share * spread.share / spread.dof;
  return 1.0 / inverse;
}

}  // namespace sagitta
