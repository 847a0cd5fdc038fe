#include "estimator/changes/comparison.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimator/least_squares/held_influence.h"
#include "estimator/least_squares/row_sums.h"
#include "estimator/report/changes_words.h"
#include "models/constants.h"
#include "models/dense_algebra.h"
#include "problems/input_error.h"
#include "problems/simulation.h"

namespace sagitta {
namespace {

constexpr int kConfigurations = 36;  // a few times as many points as a robot has parameters
constexpr double kFloor = 2e-6;      // m: less is no change of any robot, and keeps C regular
// Typical sizes of a change: what a collision, a new gearbox or a reseated reflector does to arms of 10 to 300 kg
// payload.
constexpr double kTypicalLength = 2e-4;    // m
constexpr double kTypicalAngle = 2e-4;     // rad
constexpr double kTypicalShare = 0.3;      // of a compliance or a spring's parameter
constexpr double kProbeForce = 1000.0;     // N, where loads are stated by the rows' wrenches alone
constexpr std::uint64_t kSeed = 20260101;  // of the configurations that are compared

template <typename Map>
std::vector<std::string> Shared(const Map& a, const Map& b) {
  std::vector<std::string> names;
  for (const auto& [name, value] : a) {
    if (b.count(name) > 0) names.push_back(name);
  }
  return names;
}

bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Every coordinate's column, m per SI unit.
Linearization AllColumns(const CalibrationProblem& problem, const std::vector<int>& rows) {
  std::vector<int> columns(problem.parameters.num_coordinates());
  std::iota(columns.begin(), columns.end(), 0);
  const NoiseRoots metres(rows.size(), Matrix3<double>::Identity());
  return Linearize(problem, problem.parameters, rows, columns, metres, LatentTreatment::kIgnore);
}

// Points by a joint's encoder: the joints that are coupled to it move too.
Eigen::VectorXd ZeroColumn(const Chain& chain, const Linearization& all, int joint) {
  const auto n = static_cast<long>(chain.num_joints());
  return all.latent * (chain.CoupledJointValues(Eigen::VectorXd::Unit(n, joint)) -
                       chain.CoupledJointValues(Eigen::VectorXd::Zero(n)));
}

Eigen::MatrixXd Columns(const std::vector<std::string>& names, const CalibrationProblem& problem,
                        const Linearization& all) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(all.num_rows(), static_cast<long>(names.size()));
  for (size_t i = 0; i < names.size(); ++i) {
    const int coordinate = problem.parameters.FindCoordinate(names[i]);
    if (coordinate >= 0) columns.col(static_cast<long>(i)) = all.jacobian.col(coordinate);
  }
  return columns;
}

}  // namespace

EstimateComparison::EstimateComparison(const KnownRobot& old_estimate, const KnownRobot& new_estimate)
    : old_(old_estimate), new_(new_estimate) {
  CheckSameRobot(old_, new_);
  // Both in the same conditions, and with each joint's own derivative at hand.
  const bool any_slides = std::any_of(old_.robot.chain.joints.begin(), old_.robot.chain.joints.end(),
                                      [](const Joint& joint) { return joint.type == JointType::kPrismatic; });
  const bool any_turns = std::any_of(old_.robot.chain.joints.begin(), old_.robot.chain.joints.end(),
                                     [](const Joint& joint) { return joint.type == JointType::kRevolute; });
  old_.loading.repeatability = RepeatabilitySpec();
  if (any_turns) old_.loading.repeatability.angle.common = 1.0;
  if (any_slides) old_.loading.repeatability.length.common = 1.0;
  new_.loading = old_.loading;
  const Measurements rows = MakeRows(old_, new_);
  problems_.push_back(PredictionProblem(old_, rows));
  problems_.push_back(PredictionProblem(new_, rows));
  rows_.resize(rows.observations.size());
  std::iota(rows_.begin(), rows_.end(), 0);
  ListGroups();
  for (const ChangeGroup& group : groups_) applied_.push_back(Eigen::VectorXd::Zero(group.size()));
  FactorCovariance();
}

void EstimateComparison::CheckSameRobot(const KnownRobot& a, const KnownRobot& b) const {
  const auto fail = [&](const std::string& what) {
    throw InputError({b.file, 0, "robot"}, "not the robot of " + a.file + ": " + what,
                     "give two estimates of one robot, made from the same robot description");
  };
  const Chain &x = a.robot.chain, &y = b.robot.chain;
  if (x.num_joints() != y.num_joints()) {
    fail(std::to_string(y.num_joints()) + " joints against " + std::to_string(x.num_joints()));
  }
  for (int j = 0; j < x.num_joints(); ++j) {
    if (x.joints[j].name != y.joints[j].name || x.joints[j].type != y.joints[j].type) {
      fail("joint " + std::to_string(j + 1) + " is '" + y.joints[j].name + "' against '" + x.joints[j].name + "'");
    }
  }
  if (a.robot.name != b.robot.name) fail("'" + b.robot.name + "' against '" + a.robot.name + "'");
  // Estimates differ by millimetres; another size of the same build by centimetres.
  constexpr double kOtherBuild = 0.02;
  bool same = x.num_transforms() == y.num_transforms();
  for (int e = 0; same && e < x.num_transforms(); ++e) {
    same = x.transforms[e].motion == y.transforms[e].motion && x.transforms[e].axis == y.transforms[e].axis &&
           x.transforms[e].joint == y.transforms[e].joint && x.transforms[e].sign == y.transforms[e].sign &&
           (x.transforms[e].is_rotation() || std::abs(x.transforms[e].nominal - y.transforms[e].nominal) < kOtherBuild);
  }
  if (!same) fail("the kinematic chains differ");
}

// Configurations over the joints' limits (a third of a turn to either side without), alternating over the stations.
Measurements EstimateComparison::MakeRows(const KnownRobot& a, const KnownRobot& b) {
  Measurements data;
  data.stations = Shared(a.base_in_station, b.base_in_station);
  for (const std::string& marker : Shared(a.markers, b.markers)) {
    if (a.markers.at(marker).on == b.markers.at(marker).on) data.markers.push_back(marker);
  }
  if (data.stations.empty()) throw InputError({b.file, 0, "stations"}, "no station of " + a.file + " is among them");
  if (data.markers.empty()) throw InputError({b.file, 0, "markers"}, "no marker of " + a.file + " is among them");
  std::string load;
  for (const auto& [name, spec] : a.loading.loads) {
    if (load.empty() && (spec.point || a.loading.load_point)) load = name;
  }
  if (load.empty() && a.loading.load_point) load = "probe";
  data.files.push_back({"", "", {}, {}});
  const Chain& chain = a.robot.chain;
  NormalNumbers normal(kSeed);
  for (int c = 0; c < kConfigurations; ++c) {
    Configuration configuration{"C" + std::to_string(c), Eigen::VectorXd(chain.num_joints()), false};
    for (int j = 0; j < chain.num_joints(); ++j) {
      const Joint& joint = chain.joints[j];
      const double half = joint.type == JointType::kRevolute ? 2.0 * kPi / 3.0 : 0.5;
      const double low = joint.min.value_or(-half), high = joint.max.value_or(half);
      configuration.q[j] = low + (high - low) * 0.5 * std::erfc(-normal() / std::sqrt(2.0));
    }
    data.configurations.push_back(configuration);
    for (const bool loaded : {false, true}) {
      if (loaded && load.empty()) continue;
      Shot shot;
      shot.configuration = c;
      shot.station = c % static_cast<int>(data.stations.size());
      if (loaded) {
        shot.load = load;
        const auto spec = a.loading.loads.find(load);
        if (spec == a.loading.loads.end() || !spec->second.mass) shot.wrench.force = {0.0, 0.0, -kProbeForce};
      }
      const std::string& station = data.stations[shot.station];
      const ConditionOrigins origins = a.loading.origins.value_or(ConditionOrigins());
      shot.has_time = shot.has_temperature = true;
      shot.time = origins.first_time.count(station) > 0 ? origins.first_time.at(station) : 0.0;
      shot.temperature = origins.mean_temperature;
      shot.approach.assign(chain.num_joints(), 0);
      for (size_t m = 0; m < data.markers.size(); ++m) {
        Observation observation;
        observation.shot = static_cast<int>(data.shots.size());
        observation.marker = static_cast<int>(m);
        observation.file = 0;
        observation.row = static_cast<int>(data.observations.size());
        data.files[0].rows.push_back({observation.row + 1, {}});
        shot.observations.push_back(observation.row);
        data.observations.push_back(observation);
      }
      data.shots.push_back(shot);
    }
  }
  return data;
}

// Six coordinates of a rigid motion: base/<station>, or all markers on the flange about the flange.
ChangeGroup EstimateComparison::Motion(ChangeKind kind, const std::string& target) const {
  const ParameterSet& parameters = problems_[0].parameters;
  ChangeGroup group{kind, target};
  group.coordinates.setZero(parameters.num_coordinates(), 6);
  for (int i = 0; i < 6; ++i) {
    const bool turns = i >= 3;
    group.names.push_back((turns ? "r" : "") + std::string(1, "xyz"[i % 3]));
    group.unit.push_back(1e-3);
    group.units.push_back(turns ? "mrad" : "mm");
    group.typical.push_back(turns ? kTypicalAngle : kTypicalLength);
    if (kind == ChangeKind::kBase) {
      group.coordinates(parameters.FindCoordinate("base/" + target + "/" + group.names[i]), i) = group.typical[i];
      continue;
    }
    const Vector3<double> unit = Vector3<double>::Unit(i % 3);
    for (size_t m = 0; m < problems_[0].data().markers.size(); ++m) {
      const std::string& name = problems_[0].data().markers[m];
      if (old_.markers.at(name).on.kind != MarkerPlace::Kind::kFlange) continue;
      const Vector3<double> way = turns ? unit.cross(parameters.MarkerPoint(static_cast<int>(m))) : unit;
      for (int a = 0; a < 3; ++a) {
        group.coordinates(parameters.FindCoordinate("marker/" + name + "/" + "xyz"[a]), i) = group.typical[i] * way[a];
      }
    }
  }
  return group;
}

void EstimateComparison::AddMarkers() {
  const ParameterSet& parameters = problems_[0].parameters;
  int on_flange = 0;
  for (const std::string& name : problems_[0].data().markers) {
    on_flange += old_.markers.at(name).on.kind == MarkerPlace::Kind::kFlange;
    ChangeGroup group{ChangeKind::kMarker, name};
    group.coordinates.setZero(parameters.num_coordinates(), 3);
    for (int a = 0; a < 3; ++a) {
      group.names.push_back(std::string(1, "xyz"[a]));
      group.unit.push_back(1e-3);
      group.units.push_back("mm");
      group.typical.push_back(kTypicalLength);
      group.coordinates(parameters.FindCoordinate("marker/" + name + "/" + "xyz"[a]), a) = kTypicalLength;
    }
    groups_.push_back(group);
  }
  // With one marker on the flange a knocked tool is a reseated marker.
  if (on_flange > 1) groups_.push_back(Motion(ChangeKind::kTool, "flange"));
}

void EstimateComparison::ListGroups() {
  const CalibrationProblem& problem = problems_[0];
  const Chain& chain = problem.model().chain();
  const int n = problem.parameters.num_coordinates();
  for (int j = 0; j < chain.num_joints(); ++j) {
    const bool turns = chain.joints[j].type == JointType::kRevolute;
    ChangeGroup group{ChangeKind::kJointZero, chain.joints[j].name, Eigen::MatrixXd::Zero(n, 1), j,
                      turns ? kTypicalAngle : kTypicalLength};
    group.names = {"zero"}, group.unit = {1e-3}, group.units = {turns ? "mrad" : "mm"},
    group.typical = {group.joint_size};
    groups_.push_back(group);
  }
  for (const std::string& station : problem.data().stations) groups_.push_back(Motion(ChangeKind::kBase, station));
  AddMarkers();
  for (const ModelParameter& parameter : problem.model().parameters()) {
    const int coordinate = problem.parameters.FindCoordinate(parameter.name);
    // An offset of a joint is its zero.
    if (parameter.law == ParameterLaw::kGeometry && chain.transforms[parameter.index].has_joint()) continue;
    if (new_.robot.effects.size() != old_.robot.effects.size() && parameter.law == ParameterLaw::kEffect) continue;
    double typical = parameter.quantity == Quantity::kLength ? kTypicalLength : kTypicalAngle;
    if (parameter.law != ParameterLaw::kGeometry) typical = kTypicalShare * std::abs(parameter.nominal);
    if (typical == 0.0) continue;
    const ChangeKind kind = parameter.law == ParameterLaw::kGeometry     ? ChangeKind::kGeometry
                            : parameter.law == ParameterLaw::kCompliance ? ChangeKind::kCompliance
                            : parameter.law == ParameterLaw::kEffect     ? ChangeKind::kEffect
                                                                         : ChangeKind::kCompensator;
    ChangeGroup group{kind, parameter.name.substr(parameter.name.find('/') + 1), Eigen::MatrixXd::Zero(n, 1)};
    group.coordinates(coordinate, 0) = typical;
    group.names = {"value"}, group.typical = {typical};
    group.units = {TraitsOf(parameter.quantity).unit}, group.unit = {TraitsOf(parameter.quantity).si_per_unit};
    groups_.push_back(group);
  }
}

// Root of an estimate's covariance of the predictions: S with S S' its share of C.
Eigen::MatrixXd EstimateComparison::SpreadOf(const CalibrationProblem& problem, const KnownRobot& known,
                                             const KnownRobot& other) const {
  const Linearization all = AllColumns(problem, rows_);
  const ParameterUncertainty& u = known.uncertainty;
  const Eigen::MatrixXd estimated = Columns(u.estimated, problem, all);
  std::vector<Eigen::MatrixXd> parts;
  if (!u.estimated.empty()) parts.push_back(estimated * RootOf(u.covariance));
  if (!u.held.empty()) {
    const Eigen::MatrixXd followed = estimated * u.slopes, held = Columns(u.held, problem, all) + followed;
    parts.push_back(held * RootOf(u.second_moment));
  }
  // What only this one estimated, the other assumed; what the other's parameters would have done moves along.
  for (size_t i = 0; i < u.estimated.size(); ++i) {
    const std::string& name = u.estimated[i];
    const int coordinate = problem.parameters.FindCoordinate(name);
    if (coordinate < 0 || Has(other.uncertainty.estimated, name) || Has(other.uncertainty.held, name)) continue;
    const auto p = static_cast<long>(i);
    if (!(u.covariance(p, p) > 0.0)) continue;
    const double range = PhysicalRange(problem.parameters.coordinates()[coordinate]);
    // Regression of all on the one that the other estimate assumed: C_:p / C_pp times how far it may be off.
    parts.push_back(range * (estimated * (u.covariance.col(p) / u.covariance(p, p))));
  }
  long width = 0;
  for (const Eigen::MatrixXd& part : parts) width += part.cols();
  Eigen::MatrixXd spread(all.num_rows(), width);
  width = 0;
  for (const Eigen::MatrixXd& part : parts) spread.middleCols(width, part.cols()) = part, width += part.cols();
  return spread;
}

void EstimateComparison::FactorCovariance() {
  for (const KnownRobot* known : {&old_, &new_}) {
    if (!known->uncertainty.covariance.allFinite()) {
      throw InputError({known->file, 0, "sigma"}, "this estimate does not say how well anything is known",
                       "state the noise of the measurements, or measure more than there are unknowns");
    }
  }
  const Eigen::MatrixXd a = SpreadOf(problems_[0], old_, new_), b = SpreadOf(problems_[1], new_, old_);
  Eigen::MatrixXd covariance = a * a.transpose();
  covariance += b * b.transpose();
  covariance.diagonal().array() += kFloor * kFloor;
  whitener_ = Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL();
  for (const auto& [one, other] : {std::pair(&old_, &new_), std::pair(&new_, &old_)}) {
    std::vector<std::string> names;
    for (const std::string& name : one->uncertainty.estimated) {
      const std::optional<CoordinateKind> kind = CoordinateKindOf(name);
      if (!kind || kind == CoordinateKind::kBase || kind == CoordinateKind::kMarker) continue;
      if (!Has(other->uncertainty.estimated, name) && !Has(other->uncertainty.held, name)) names.push_back(name);
    }
    if (names.empty()) continue;
    notes_.push_back(ChangesOpen(one->file, names));
  }
}

Eigen::VectorXd EstimateComparison::Difference() const {
  const Eigen::Matrix3Xd from = PredictPoints(problems_[0], problems_[0].parameters, rows_);
  const Eigen::Matrix3Xd to = PredictPoints(problems_[1], problems_[1].parameters, rows_);
  const Eigen::Matrix3Xd difference = to - from;
  return Eigen::Map<const Eigen::VectorXd>(difference.data(), difference.size());
}

double EstimateComparison::Rms() const {
  return std::sqrt(Difference().squaredNorm() / static_cast<double>(rows_.size()));
}

EstimateComparison::Linear EstimateComparison::Linearise() const {
  const Linearization all = AllColumns(problems_[0], rows_);
  Linear linear;
  int width = 0;
  for (const ChangeGroup& group : groups_) width += group.size();
  linear.columns.resize(all.num_rows(), width);
  Eigen::VectorXd applied(width);
  int first = 0;
  for (size_t g = 0; g < groups_.size(); ++g) {
    const ChangeGroup& group = groups_[g];
    auto columns = linear.columns.middleCols(first, group.size());
    columns.noalias() = all.jacobian * group.coordinates;
    if (group.joint >= 0)
      columns.col(0) += group.joint_size * ZeroColumn(problems_[0].model().chain(), all, group.joint);
    applied.segment(first, group.size()) = applied_[g];
    std::vector<int> indices(group.size());
    std::iota(indices.begin(), indices.end(), first);
    linear.of_group.push_back(indices);
    first += group.size();
  }
  linear.difference = Difference() + linear.columns * applied;
  const auto lower = whitener_.triangularView<Eigen::Lower>();
  lower.solveInPlace(linear.difference);
  lower.solveInPlace(linear.columns);
  return linear;
}

void EstimateComparison::MoveTo(const std::vector<Eigen::VectorXd>& applied) {
  CalibrationProblem& problem = problems_[0];
  std::vector<ShotInput>& inputs = *problem.mutable_shot_inputs();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(problem.parameters.num_coordinates());
  for (size_t g = 0; g < groups_.size(); ++g) {
    const Eigen::VectorXd way = applied[g] - applied_[g];
    step += groups_[g].coordinates * way;
    if (groups_[g].joint < 0 || way[0] == 0.0) continue;
    for (ShotInput& shot : inputs) shot.conditions.q[groups_[g].joint] += groups_[g].joint_size * way[0];
  }
  problem.model().Prepare(&inputs);
  problem.parameters.Plus(step);
  applied_ = applied;
}

}  // namespace sagitta
