#include "problems/parameter_set.h"

#include <cmath>

namespace sagitta {
namespace {

CoordinateKind KindOfLaw(ParameterLaw law) {
  switch (law) {
    case ParameterLaw::kGeometry:
      return CoordinateKind::kGeometry;
    case ParameterLaw::kCompliance:
      return CoordinateKind::kCompliance;
    case ParameterLaw::kCompensator:
      return CoordinateKind::kCompensator;
    case ParameterLaw::kEffect:
      break;
  }
  return CoordinateKind::kEffect;
}

// kind/target: base/S1.
std::string NameOf(CoordinateKind kind, const std::string& target) { return WordOf(kind) + ("/" + target); }

std::array<std::string, 6> SixNames(const std::string& of) {
  return {of + "/x", of + "/y", of + "/z", of + "/rx", of + "/ry", of + "/rz"};
}

}  // namespace

std::string WordOf(CoordinateKind kind) {
  switch (kind) {
    case CoordinateKind::kBase:
      return "base";
    case CoordinateKind::kMarker:
      return "marker";
    case CoordinateKind::kGeometry:
      return "geometry";
    case CoordinateKind::kCompliance:
      return "compliance";
    case CoordinateKind::kCompensator:
      return "compensator";
    case CoordinateKind::kEffect:
      return "effect";
  }
  return "";
}

std::optional<CoordinateKind> CoordinateKindOf(const std::string& name) {
  return FindChoice<CoordinateKind>(name.substr(0, name.find('/')));
}

std::string NameWithinKind(const std::string& name) {
  const size_t slash = name.find('/');
  return slash == std::string::npos ? "" : name.substr(slash + 1);
}

bool IsWithin(const std::string& name, const std::string& prefix) {
  return name == prefix || name.rfind(prefix + "/", 0) == 0;
}

std::array<std::string, 6> BaseNames(const std::string& station) {
  return SixNames(NameOf(CoordinateKind::kBase, station));
}

std::array<std::string, 6> MarkerNames(const std::string& marker) {
  return SixNames(NameOf(CoordinateKind::kMarker, marker));
}

ParameterSet::ParameterSet() = default;
ParameterSet::ParameterSet(const ParameterSet&) = default;
ParameterSet::ParameterSet(ParameterSet&&) noexcept = default;
ParameterSet& ParameterSet::operator=(const ParameterSet&) = default;
ParameterSet& ParameterSet::operator=(ParameterSet&&) noexcept = default;
ParameterSet::~ParameterSet() = default;

ParameterSet::ParameterSet(const std::vector<std::string>& stations, const std::vector<std::string>& markers,
                           const std::vector<ModelParameter>& model_parameters, const std::vector<bool>& oriented)
    : num_stations_(stations.size()), num_markers_(markers.size()), num_model_parameters_(model_parameters.size()) {
  const auto add_block = [this](const std::string& name, BlockKind kind, int owner, std::vector<double> values,
                                const std::vector<std::string>& coordinates, Quantity quantity, CoordinateKind of) {
    ParameterBlock block{name, kind, owner, std::move(values), num_coordinates(), static_cast<int>(coordinates.size())};
    for (size_t i = 0; i < coordinates.size(); ++i) {
      coordinates_.push_back({coordinates[i], quantity, static_cast<int>(blocks_.size()), static_cast<int>(i)});
      coordinates_.back().hold_limit = TraitsOf(quantity).hold_limit;
      coordinates_.back().kind = of;
    }
    blocks_.push_back(std::move(block));
  };
  const auto lengths = [](const std::array<std::string, 6>& six) {
    return std::vector<std::string>(six.begin(), six.begin() + 3);
  };
  const auto turns = [](const std::array<std::string, 6>& six) {
    return std::vector<std::string>(six.begin() + 3, six.end());
  };
  for (int s = 0; s < num_stations_; ++s) {
    const std::string base = NameOf(CoordinateKind::kBase, stations[s]);
    const std::array<std::string, 6> names = BaseNames(stations[s]);
    add_block(base + "/position", BlockKind::kStationTranslation, s, {0, 0, 0}, lengths(names), Quantity::kLength,
              CoordinateKind::kBase);
    add_block(base + "/rotation", BlockKind::kStationRotation, s, {0, 0, 0, 1}, turns(names), Quantity::kRotationVector,
              CoordinateKind::kBase);
  }
  for (int m = 0; m < num_markers_; ++m) {
    add_block(NameOf(CoordinateKind::kMarker, markers[m]), BlockKind::kMarker, m, {0, 0, 0},
              lengths(MarkerNames(markers[m])), Quantity::kLength, CoordinateKind::kMarker);
  }
  rotation_block_.assign(markers.size(), -1);
  for (size_t m = 0; m < oriented.size(); ++m) {
    if (!oriented[m]) continue;
    rotation_block_[m] = static_cast<int>(blocks_.size());
    add_block(NameOf(CoordinateKind::kMarker, markers[m]) + "/rotation", BlockKind::kMarkerRotation,
              static_cast<int>(m), {0, 0, 0, 1}, turns(MarkerNames(markers[m])), Quantity::kRotationVector,
              CoordinateKind::kMarker);
  }
  first_model_block_ = static_cast<int>(blocks_.size());
  for (int i = 0; i < num_model_parameters_; ++i) {
    const ModelParameter& parameter = model_parameters[i];
    add_block(parameter.name, BlockKind::kModelParameter, i, {parameter.nominal}, {parameter.name}, parameter.quantity,
              KindOfLaw(parameter.law));
    coordinates_.back().lower = parameter.lower;
    coordinates_.back().prior_sigma = coordinates_.back().effect_prior = parameter.prior_sigma;
    if (parameter.law == ParameterLaw::kCompensator) {
      coordinates_.back().compensator_part = static_cast<CompensatorPart>(parameter.index);
      coordinates_.back().prior_value = parameter.nominal;
    }
  }
}

int ParameterSet::FindCoordinate(const std::string& name) const {
  for (int i = 0; i < num_coordinates(); ++i) {
    if (coordinates_[i].name == name) return i;
  }
  return -1;
}

int ParameterSet::FindCoordinate(CompensatorPart part) const {
  for (int i = 0; i < num_coordinates(); ++i) {
    if (coordinates_[i].compensator_part == part) return i;
  }
  return -1;
}

std::vector<int> ParameterSet::Match(const std::string& prefix) const {
  std::vector<int> matches;
  for (int i = 0; i < num_coordinates(); ++i) {
    if (IsWithin(coordinates_[i].name, prefix)) matches.push_back(i);
  }
  return matches;
}

std::vector<int> ParameterSet::EstimatedCoordinates() const {
  std::vector<int> estimated;
  for (int i = 0; i < num_coordinates(); ++i) {
    if (coordinates_[i].estimated()) estimated.push_back(i);
  }
  return estimated;
}

Pose<double> ParameterSet::BaseInStation(int station) const {
  Pose<double> pose;
  pose.translation = Eigen::Map<const Vector3<double>>(station_translation(station).values.data());
  pose.rotation = Eigen::Map<const Eigen::Quaterniond>(station_rotation(station).values.data()).toRotationMatrix();
  return pose;
}

void ParameterSet::SetBaseInStation(int station, const Pose<double>& base_in_station) {
  Eigen::Map<Vector3<double>>(station_translation(station).values.data()) = base_in_station.translation;
  Eigen::Map<Eigen::Quaterniond>(station_rotation(station).values.data()) =
      Eigen::Quaterniond(base_in_station.rotation).normalized();
}

Vector3<double> ParameterSet::MarkerPoint(int m) const {
  return Eigen::Map<const Vector3<double>>(marker(m).values.data());
}

void ParameterSet::SetMarkerPoint(int m, const Vector3<double>& point) {
  Eigen::Map<Vector3<double>>(marker(m).values.data()) = point;
}

Matrix3<double> ParameterSet::MarkerRotation(int m) const {
  if (!is_oriented(m)) return Matrix3<double>::Identity();
  return Eigen::Map<const Eigen::Quaterniond>(marker_rotation(m).values.data()).normalized().toRotationMatrix();
}

void ParameterSet::SetMarkerRotation(int m, const Matrix3<double>& rotation) {
  if (!is_oriented(m)) return;
  Eigen::Map<Eigen::Quaterniond>(marker_rotation(m).values.data()) = Eigen::Quaterniond(rotation).normalized();
}

MarkerInFrame ParameterSet::MarkerOn(int frame, int m, ReadingKind kind) const {
  return {frame, MarkerPoint(m), m, kind, MarkerRotation(m)};
}

void ParameterSet::SetSpringTie(const SpringTie& tie) { spring_tie_ = tie; }
void ParameterSet::DropSpringTie() { spring_tie_.reset(); }

std::vector<double> ParameterSet::ModelValues() const {
  std::vector<double> theta(num_model_parameters_);
  for (int i = 0; i < num_model_parameters_; ++i) theta[i] = model_parameter(i).values[0];
  return theta;
}

void ParameterSet::SetModelValue(int i, double value) { model_parameter(i).values[0] = value; }

double ParameterSet::Value(int coordinate) const {
  const Coordinate& c = coordinates_[coordinate];
  const ParameterBlock& block = blocks_[c.block];
  if (!IsRotation(block.kind)) return block.values[c.index_in_block];
  return RotationVector(Eigen::Map<const Eigen::Quaterniond>(block.values.data()))[c.index_in_block];
}

void ParameterSet::CopyByName(const ParameterSet& other) {
  std::map<std::string, const ParameterBlock*> known;
  for (const ParameterBlock& block : other.blocks_) known[block.name] = &block;
  for (ParameterBlock& block : blocks_) {
    const auto found = known.find(block.name);
    if (found == known.end()) continue;
    block.values = found->second->values;
    for (int i = 0; i < block.tangent_size; ++i) {
      Coordinate& own = coordinates_[block.first_coordinate + i];
      const Coordinate& theirs = other.coordinates_[found->second->first_coordinate + i];
      own.free = theirs.free;
      own.held = theirs.held;
      own.prior_value = theirs.prior_value;
      own.prior_sigma = theirs.prior_sigma;
      own.effect_prior = theirs.effect_prior;
      own.hold_limit = theirs.hold_limit;
    }
  }
}

void ParameterSet::Plus(const Eigen::VectorXd& delta) {
  for (ParameterBlock& block : blocks_) {
    const double* step = delta.data() + block.first_coordinate;
    if (IsRotation(block.kind)) {
      Eigen::Map<Eigen::Quaterniond> rotation(block.values.data());
      const Vector3<double> v(step[0], step[1], step[2]);
      rotation = (QuaternionFromRotationVector(v) * rotation).normalized();
    } else {
      for (int i = 0; i < block.tangent_size; ++i) block.values[i] += step[i];
    }
  }
}

}  // namespace sagitta
