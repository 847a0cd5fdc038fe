// Named blocks own every unknown; results speak in these names (FORMATS
// section 4: base/<station>/x.., marker/<id>/x.., marker/<id>/rx.. where poses
// of it are read, geometry/<error>).
//
// A block holds ambient values: a translation, a point, a scalar, or a unit
// quaternion (x, y, z, w) whose tangent is a left perturbation
// R = exp(delta) R_hat, in rad. A *coordinate* is one tangent direction: one
// column of the identification Jacobian, one line of the result table.
#pragma once

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "models/forward_model.h"
#include "models/geometry.h"
#include "models/gravity_compensator.h"
#include "models/quantity.h"
#include "problems/choices.h"
#include "problems/spring_tie.h"

namespace sagitta {

// What a coordinate is of; its name begins with it.
enum class CoordinateKind { kBase, kMarker, kGeometry, kCompliance, kCompensator, kEffect };
std::string WordOf(CoordinateKind kind);

// Of a name in a file, e.g. kGeometry of geometry/A2.theta; nothing where it is none.
std::optional<CoordinateKind> CoordinateKindOf(const std::string& name);
// What follows the kind: A2.theta; "" where nothing does.
std::string NameWithinKind(const std::string& name);
// Whether it is `prefix` or starts with `prefix/`.
bool IsWithin(const std::string& name, const std::string& prefix);

// Names of the coordinates of a station's base: x, y, z, rx, ry, rz.
std::array<std::string, 6> BaseNames(const std::string& station);
// Those of a marker; the last three are where poses of it are read.
std::array<std::string, 6> MarkerNames(const std::string& marker);

// One tangent direction of a block: one unknown.
struct Coordinate {
  std::string name;
  Quantity quantity = Quantity::kLength;
  int block = -1;
  int index_in_block = 0;  // of the tangent
  bool free = true;        // asked for
  bool held = false;       // asked for, but the data do not determine it: stays where it is
  double lower = -std::numeric_limits<double>::infinity();  // SI
  double prior_value = 0.0;                                 // SI
  double prior_sigma = 0.0;                                 // SI; 0: no prior
  // SI; of a prior that the robot file states of an effect or a spring, where rows scatter as is stated; 0: it states
  // none. prior_sigma is that for rows as they scatter (estimator/calibration/effect_priors.h).
  double effect_prior = 0.0;
  // SI; a direction whose standard deviation exceeds it is unidentifiable: of its kind (TraitsOf), or 5 mm or 5 mrad of
  // what it moves (problems/excitation.h).
  double hold_limit = 0.0;
  CoordinateKind kind = CoordinateKind::kBase;
  std::optional<CompensatorPart> compensator_part = {};
  bool estimated() const { return free && !held; }
  bool has_prior() const { return prior_sigma > 0.0; }
  // One that the experiment states; that of an effect or a spring that the rows hardly determine is no statement.
  bool has_stated_prior() const { return has_prior() && !(effect_prior > 0.0); }
};

// What a coordinate's prior adds to the residuals where the coordinate is `value` (SI): its distance from what the
// prior states, in standard deviations. Its derivative is 1 / prior_sigma.
inline double PriorResidual(const Coordinate& coordinate, double value) {
  return (value - coordinate.prior_value) / coordinate.prior_sigma;
}

// What the values of a block are.
enum class BlockKind { kStationTranslation, kStationRotation, kMarker, kMarkerRotation, kModelParameter };
// Unit quaternions with a left perturbation.
inline bool IsRotation(BlockKind kind) {
  return kind == BlockKind::kStationRotation || kind == BlockKind::kMarkerRotation;
}

// Values that the solver moves together; a rotation is a quaternion with three tangent directions.
struct ParameterBlock {
  std::string name;  // base/<station>/position, base/<station>/rotation, marker/<id>, geometry/<error>
  BlockKind kind = BlockKind::kModelParameter;
  int owner = -1;  // station, marker or model parameter index
  std::vector<double> values;
  int first_coordinate = 0;
  int tangent_size = 1;
};

// All unknowns of a problem, by name and by coordinate.
class ParameterSet {
 public:
  ParameterSet();
  ParameterSet(const ParameterSet&);
  ParameterSet(ParameterSet&&) noexcept;
  ParameterSet& operator=(const ParameterSet&);
  ParameterSet& operator=(ParameterSet&&) noexcept;
  ~ParameterSet();
  // oriented: the markers whose rotation is an unknown too; empty: none.
  ParameterSet(const std::vector<std::string>& stations, const std::vector<std::string>& markers,
               const std::vector<ModelParameter>& model_parameters, const std::vector<bool>& oriented = {});

  const std::vector<ParameterBlock>& blocks() const { return blocks_; }
  const std::vector<Coordinate>& coordinates() const { return coordinates_; }
  Coordinate& coordinate(int i) { return coordinates_[i]; }
  int num_coordinates() const { return static_cast<int>(coordinates_.size()); }
  int num_stations() const { return num_stations_; }
  int num_markers() const { return num_markers_; }
  int num_model_parameters() const { return num_model_parameters_; }
  // -1: there is no coordinate of that name.
  int FindCoordinate(const std::string& name) const;
  // -1: the robot has no compensator.
  int FindCoordinate(CompensatorPart part) const;
  // Coordinates whose name is within `prefix`.
  std::vector<int> Match(const std::string& prefix) const;
  std::vector<int> EstimatedCoordinates() const;

  // Blocks by what they are. Pointers stay valid as long as the set lives.
  ParameterBlock& station_translation(int station) { return blocks_[2 * station]; }
  ParameterBlock& station_rotation(int station) { return blocks_[2 * station + 1]; }
  ParameterBlock& marker(int marker) { return blocks_[2 * num_stations_ + marker]; }
  ParameterBlock& model_parameter(int i) { return blocks_[first_model_block_ + i]; }
  const ParameterBlock& station_translation(int station) const { return blocks_[2 * station]; }
  const ParameterBlock& station_rotation(int station) const { return blocks_[2 * station + 1]; }
  const ParameterBlock& marker(int marker) const { return blocks_[2 * num_stations_ + marker]; }
  const ParameterBlock& model_parameter(int i) const { return blocks_[first_model_block_ + i]; }
  bool is_oriented(int marker) const { return rotation_block_[marker] >= 0; }
  ParameterBlock& marker_rotation(int marker) { return blocks_[rotation_block_[marker]]; }
  const ParameterBlock& marker_rotation(int marker) const { return blocks_[rotation_block_[marker]]; }
  // What of the marker a reading depends on: its point or its rotation.
  ParameterBlock& read_block(int m, ReadingKind kind) {
    return kind == ReadingKind::kPoint ? marker(m) : marker_rotation(m);
  }
  const ParameterBlock& read_block(int m, ReadingKind kind) const {
    return kind == ReadingKind::kPoint ? marker(m) : marker_rotation(m);
  }

  Pose<double> BaseInStation(int station) const;
  void SetBaseInStation(int station, const Pose<double>& base_in_station);
  Vector3<double> MarkerPoint(int marker) const;
  void SetMarkerPoint(int marker, const Vector3<double>& point);
  Matrix3<double> MarkerRotation(int marker) const;  // frame_from_target; the identity where it is no unknown
  void SetMarkerRotation(int marker, const Matrix3<double>& rotation);
  // The marker as a reading of that kind needs it.
  MarkerInFrame MarkerOn(int frame, int marker, ReadingKind kind) const;
  std::vector<double> ModelValues() const;  // theta
  void SetModelValue(int i, double value);

  // A prior that links several blocks: markers on the compensator's spring.
  const std::optional<SpringTie>& spring_tie() const { return spring_tie_; }
  void SetSpringTie(const SpringTie& tie);
  void DropSpringTie();

  // A coordinate's value as results state it (rotations: rotation vector), SI.
  double Value(int coordinate) const;
  // Copies values, flags, limits and priors of every block that both sets have.
  void CopyByName(const ParameterSet& other);
  // Moves by a tangent step over all coordinates, SI.
  void Plus(const Eigen::VectorXd& delta);

 private:
  std::vector<ParameterBlock> blocks_;
  std::vector<Coordinate> coordinates_;
  std::optional<SpringTie> spring_tie_;
  std::vector<int> rotation_block_;  // of each marker, -1: none
  int first_model_block_ = 0;
  int num_stations_ = 0;
  int num_markers_ = 0;
  int num_model_parameters_ = 0;
};

}  // namespace sagitta
