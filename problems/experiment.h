// An experiment as its file states it (sagitta/experiment/1), SI inside but for Prior, which is in the unit of results.
// Everything that FORMATS section 3 lists is read; what a method does not
// support yet it refuses with words, it never ignores it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "models/constants.h"
#include "models/geometry.h"
#include "models/wrench.h"
#include "problems/choices.h"
#include "problems/significance.h"

namespace sagitta {

struct LoadSpec {
  std::optional<double> mass;            // kg
  std::optional<Vector3<double>> point;  // m, flange frame
  WrenchFrame frame = WrenchFrame::kMeasurement;
};

// What a marker rides on.
struct MarkerPlace {
  enum class Kind { kFlange, kBase, kWorld, kJoint };  // kJoint, which has no word of its own, is the last
  Kind kind = Kind::kFlange;
  std::string joint;  // of kJoint: on the link that it moves

  // Of the word in files: flange, base, world; every other is a joint's name.
  static MarkerPlace Named(const std::string& word);
  std::string Word() const;
  static std::vector<std::string> Words();  // of all but joints
  bool operator==(const MarkerPlace& other) const { return kind == other.kind && joint == other.joint; }
};
// "flange", "base", "world"; "": a joint has its own name.
std::string WordOf(MarkerPlace::Kind kind);

// A marker as stated: where it sits and on what.
struct MarkerSpec {
  std::optional<Vector3<double>> point;  // m, in the frame it is on
  MarkerPlace on;
  std::optional<Vector3<double>> rotvec;  // rad, frame_from_target, of a target whose pose is read
  std::optional<SpringEnd> spring;        // end of the compensator's spring that it is; empty: not stated
  std::optional<double> spring_sigma;     // m, per coordinate: how well it sits on that end
};

// A station as stated: where the base is seen from it.
struct StationSpec {
  std::optional<Vector3<double>> base_xyz;        // m; base pose in the station frame
  std::optional<Vector3<double>> base_rotvec;     // rad
  std::optional<Vector3<double>> instrument_xyz;  // m, where the instrument stands in the measurement frame
  std::optional<bool> levelled;
};

// Where the noise of the readings comes from.
struct NoiseSpec {
  enum class From { kDefault, kSigma, kRows, kRepeats, kResiduals, kInstrument, kVarianceComponents };
  From from = From::kDefault;   // rows where stated, else estimated
  std::optional<double> sigma;  // m, where a row has none
  bool replaces_rows = false;   // --sigma_mm
  double lambda = 1.0;          // paper 003 eq. (14)
  double sigma0 = 1e-5;         // m
  ResidualGroup group = ResidualGroup::kConfigAxis;
  int iterations = 10;
  double range = 0.0, range_per_m = 0.0, angle = 0.0, angle_per_m = 0.0;  // m, m/m
};

// Standard deviation of what a joint repeats by from arrival to arrival.
struct RepeatabilitySpec {
  // Of the revolute joints in rad, of the prismatic ones in m.
  struct OfKind {
    bool estimate = false;  // where nothing is stated
    std::optional<double> common;
    std::map<std::string, double> per_joint;

    // Empty where none is stated: estimated, or 0.
    std::optional<double> StatedFor(const std::string& joint) const {
      const auto own = per_joint.find(joint);
      return own != per_joint.end() ? own->second : common;
    }
    bool IsZero() const { return !estimate && !common && per_joint.empty(); }
  };
  OfKind angle, length;

  // Of the keys repeatability_urad, ...; the first of a kind is the one to suggest.
  static constexpr const char* kAngleUnits[] = {"urad", "mrad", "rad", "deg"};
  static constexpr const char* kLengthUnits[] = {"um", "mm", "m"};

  const OfKind& Of(JointType type) const { return type == JointType::kRevolute ? angle : length; }
  bool IsEstimated() const { return angle.estimate || length.estimate; }
  bool IsZero() const { return angle.IsZero() && length.IsZero(); }
};

// What time and temperature count from: the earliest row of all, each station's earliest row, wherever it stands in the
// files, and the mean of the data.
struct ConditionOrigins {
  std::optional<double> campaign_time;       // s; absent: no row states a time
  std::map<std::string, double> first_time;  // s, by station
  double mean_temperature = 0.0;             // degC
};

// default | all | none | a list of names.
struct Selection {
  enum class Kind { kDefault, kAll, kNone, kList };
  Kind kind = Kind::kDefault;
  std::vector<std::string> names;
};

// What is unknown.
struct EstimateSpec {
  bool base = true;
  bool markers = true;
  Selection geometry;
  Selection compliance;
  Selection gravity_compensator;
  Selection effects;
  std::vector<std::string> fixed;  // parameter names or their prefixes, e.g. base/S1
  std::vector<std::string> free;
};

// Knowledge from elsewhere of one parameter, not in SI: {0, 0.001} of a length is 1 um.
struct Prior {
  double value = 0.0;  // in the parameter's unit of FORMATS section 4: mm, mrad, deg, urad/Nm, N/mm, …
  double sigma = 0.0;  // standard deviation, in the same unit
};

// Which configurations are set aside.
struct ValidationSpec {
  enum class Kind { kSetColumn, kNone, kColumn, kFraction };
  Kind kind = Kind::kSetColumn;  // the column `set` where the data have one
  bool needs_column = false;     // `set`: it was asked for
  std::string column;
  std::vector<std::string> values;
  double fraction = 0.0;
  unsigned long long seed = 1;
  bool by_time = false;
};

// How `covariance: bootstrap` draws.
struct BootstrapSpec {
  BootstrapKind kind = BootstrapKind::kAutomatic;
  int replicates = 999;
  unsigned long long seed = 1;
};

// How to solve, and what the intervals are made of.
struct MethodSpec {
  Weights weights = Weights::kSigma;
  LossKind loss = LossKind::kNone;
  CovarianceKind covariance = CovarianceKind::kModel;
  BootstrapSpec bootstrap;
};

// Everything that the file states; each default is the one that FORMATS.md gives.
struct Experiment {
  // Compiled once (experiment.cc), not in each file that holds one.
  Experiment();
  Experiment(const Experiment&);
  Experiment(Experiment&&) noexcept;
  Experiment& operator=(const Experiment&);
  Experiment& operator=(Experiment&&) noexcept;
  ~Experiment();

  std::string file;  // "" when put together from the command line
  std::string sha256;
  std::map<std::string, int> lines;  // of every key of the file by its path: estimate.compliance
  std::string robot_file;
  std::vector<std::string> measurement_files;
  std::optional<Vector3<double>> load_point;  // m, flange frame
  std::map<std::string, LoadSpec> loads;
  double tool_mass = 0.0;                                         // kg
  Vector3<double> tool_com = Vector3<double>::Zero();             // m
  Vector3<double> gravity_direction = -Vector3<double>::UnitZ();  // unit
  bool gravity_in_base = false;
  double gravity = kStandardGravity;  // m/s^2
  std::map<std::string, MarkerSpec> markers;
  std::map<std::string, StationSpec> stations;
  NoiseSpec noise;
  RepeatabilitySpec repeatability;
  MethodSpec method;
  EstimateSpec estimate;
  std::map<std::string, Prior> priors;
  ValidationSpec validation;
  double significance = kDefaultSignificance;
  bool torques_measured = false;  // `torques: measured`: the columns tau<i> drive joint-wise elastic effects
  // Of the data that an estimate was made of, where other rows are predicted with it; absent: of the rows themselves.
  std::optional<ConditionOrigins> origins = {};
};

}  // namespace sagitta
