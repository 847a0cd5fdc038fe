#include "estimator/changes/change_groups.h"

#include <algorithm>
#include <cmath>

#include "models/effects/catalogue.h"
#include "models/geometry.h"
#include "models/steel.h"

namespace sagitta {
namespace {

// Typical sizes of a change: what a collision, a new gearbox or a reseated reflector does to arms of 10 to 300 kg
// payload.
constexpr double kTypicalLength = 2e-4;  // m
constexpr double kTypicalAngle = 2e-4;   // rad
constexpr double kTypicalShare = 0.3;    // of a compliance or a spring's parameter
// Of all lengths: two kelvin of steel. An instrument's air that is 20 K off makes as much.
constexpr double kTypicalScale = 2.0 * kSteelPerKelvin;

ChangeGroup JointZeroGroup(const Chain& chain, int j) {
  const bool turns = chain.joints[j].type == JointType::kRevolute;
  ChangeGroup group{ChangeKind::kJointZero, chain.joints[j].name, j};
  group.names = {"zero"}, group.unit = {1e-3}, group.units = {turns ? "mrad" : "mm"};
  group.typical = {turns ? kTypicalAngle : kTypicalLength};
  return group;
}

void AddAxis(int axis, bool turns, ChangeGroup* group) {
  group->names.push_back((turns ? "r" : "") + std::string(1, "xyz"[axis]));
  group->unit.push_back(1e-3);
  group->units.push_back(turns ? "mrad" : "mm");
  group->typical.push_back(turns ? kTypicalAngle : kTypicalLength);
}

ChangeGroup BaseGroup(const CalibrationProblem& problem, int station, bool of_campaign) {
  ChangeGroup group{ChangeKind::kBase, problem.data().stations[station], station};
  group.of_campaign = of_campaign;
  for (int i = 0; i < 6; ++i) AddAxis(i % 3, i >= 3, &group);
  for (const std::string& name : BaseNames(group.target)) {
    group.coordinates.push_back(problem.parameters.FindCoordinate(name));
  }
  return group;
}

ChangeGroup MarkerGroup(const CalibrationProblem& problem, int marker, bool of_campaign) {
  ChangeGroup group{ChangeKind::kMarker, problem.data().markers[marker], marker};
  group.of_campaign = of_campaign;
  const std::array<std::string, 6> names = MarkerNames(group.target);
  for (int a = 0; a < 3; ++a) {
    AddAxis(a, false, &group);
    group.coordinates.push_back(problem.parameters.FindCoordinate(names[a]));
  }
  return group;
}

// Markers that were mounted anew, each by its own amount.
ChangeGroup AllAnew(const std::vector<ChangeGroup>& markers) {
  ChangeGroup all{ChangeKind::kMarkers, "flange"};
  for (const ChangeGroup& marker : markers) {
    for (int a = 0; a < 3; ++a) {
      AddAxis(a, false, &all);
      all.names.back() = marker.target + "/" + all.names.back();
    }
    all.coordinates.insert(all.coordinates.end(), marker.coordinates.begin(), marker.coordinates.end());
  }
  return all;
}

// Every marker, and those on the flange as one body, or all mounted anew: with one of these a knocked tool is a
// reseated marker. Nine numbers of three markers are those of a tool and one marker, too: what is one cause has the
// higher prior.
void AddMarkers(const CalibrationProblem& problem, const KnownRobot& known, const CampaignsOwn& own,
                std::vector<ChangeGroup>* groups) {
  ChangeGroup tool{ChangeKind::kTool, "flange"};
  for (int i = 0; i < 6; ++i) AddAxis(i % 3, i >= 3, &tool);
  std::vector<ChangeGroup> on_flange;
  const std::vector<std::string>& markers = problem.data().markers;
  for (size_t m = 0; m < markers.size(); ++m) {
    const auto index = static_cast<int>(m);
    groups->push_back(MarkerGroup(problem, index, own.markers));
    if (known.markers.at(markers[m]).on.kind != MarkerPlace::Kind::kFlange) continue;
    tool.carried.push_back(index);
    on_flange.push_back(groups->back());
  }
  if (on_flange.size() < 2 || own.markers) return;
  groups->push_back(tool);
  groups->push_back(AllAnew(on_flange));
}

// Lengths of the arm and its distance to the instrument: an arm that is warmer grows by itself, what measures by
// another scale sees both grow.
ChangeGroup ScaleGroup() {
  ChangeGroup group{ChangeKind::kScale, "lengths"};
  group.names = {"arm", "distance"}, group.unit = {1e-6, 1e-6}, group.units = {"ppm", "ppm"};
  group.typical = {kTypicalScale, kTypicalScale};
  return group;
}

// What goes with time is of each campaign; what it has done is in zeros, bases and markers.
bool GoesWithTime(const CalibrationProblem& problem, const ModelParameter& parameter) {
  return GoesWithTime(problem.robot(), problem.robot().effects[static_cast<size_t>(parameter.index)]);
}

void AddDesignParameters(const CalibrationProblem& problem, bool with_effects, std::vector<ChangeGroup>* groups) {
  const Chain& chain = problem.model().chain();
  for (const ModelParameter& parameter : problem.model().parameters()) {
    // An offset of a joint is its zero.
    if (parameter.law == ParameterLaw::kGeometry && chain.transforms[parameter.index].has_joint()) continue;
    if (parameter.law == ParameterLaw::kEffect && (!with_effects || GoesWithTime(problem, parameter))) continue;
    double typical = parameter.quantity == Quantity::kLength ? kTypicalLength : kTypicalAngle;
    if (parameter.law != ParameterLaw::kGeometry) typical = kTypicalShare * std::abs(parameter.nominal);
    if (typical == 0.0) continue;
    const ChangeKind kind = parameter.law == ParameterLaw::kGeometry     ? ChangeKind::kGeometry
                            : parameter.law == ParameterLaw::kCompliance ? ChangeKind::kCompliance
                            : parameter.law == ParameterLaw::kEffect     ? ChangeKind::kEffect
                                                                         : ChangeKind::kCompensator;
    ChangeGroup group{kind, NameWithinKind(parameter.name)};
    group.coordinates = {problem.parameters.FindCoordinate(parameter.name)};
    group.names = {"value"}, group.typical = {typical};
    group.units = {TraitsOf(parameter.quantity).unit}, group.unit = {TraitsOf(parameter.quantity).si_per_unit};
    groups->push_back(group);
  }
}

}  // namespace

std::string WordOf(ChangeKind kind) {
  switch (kind) {
    case ChangeKind::kJointZero:
      return "joint_zero";
    case ChangeKind::kTool:
      return "tool";
    case ChangeKind::kMarker:
      return "marker";
    case ChangeKind::kMarkers:
      return "markers";
    case ChangeKind::kBase:
      return "base";
    case ChangeKind::kScale:
      return "scale";
    case ChangeKind::kGeometry:
      return "geometry";
    case ChangeKind::kCompliance:
      return "compliance";
    case ChangeKind::kCompensator:
      return "compensator";
    case ChangeKind::kEffect:
      return "effect";
  }
  return "";
}

std::vector<ChangeGroup> ListChangeGroups(const CalibrationProblem& problem, const KnownRobot& old_estimate,
                                          const KnownRobot& new_estimate, const CampaignsOwn& own) {
  std::vector<ChangeGroup> groups;
  const Chain& chain = problem.model().chain();
  for (int j = 0; j < chain.num_joints(); ++j) groups.push_back(JointZeroGroup(chain, j));
  for (int s = 0; s < problem.parameters.num_stations(); ++s) groups.push_back(BaseGroup(problem, s, own.station));
  AddMarkers(problem, old_estimate, own, &groups);
  groups.push_back(ScaleGroup());
  AddDesignParameters(problem, new_estimate.robot.effects.size() == old_estimate.robot.effects.size(), &groups);
  return groups;
}

bool IsPartOf(const ChangeGroup& part, const ChangeGroup& all) {
  if (all.kind != ChangeKind::kMarkers) return false;
  const auto is_own = [&](int coordinate) {
    return std::find(all.coordinates.begin(), all.coordinates.end(), coordinate) != all.coordinates.end();
  };
  return part.kind == ChangeKind::kTool || (part.kind == ChangeKind::kMarker && is_own(part.coordinates[0]));
}

Matrix3<double> RotationOf(const ChangeGroup& group, const Eigen::VectorXd& change) {
  const Vector3<double> turn(change[3] * group.typical[3], change[4] * group.typical[4], change[5] * group.typical[5]);
  return RotationFromVector<double>(turn);
}

Eigen::VectorXd Further(const ChangeGroup& group, const Eigen::VectorXd& change, const Eigen::VectorXd& step) {
  Eigen::VectorXd sum = change + step;
  if (!group.is_motion()) return sum;
  // R = exp(step) exp(change), as the columns of a rotation are left perturbations.
  const Vector3<double> turn = RotationVector(Matrix3<double>(RotationOf(group, step) * RotationOf(group, change)));
  for (int a = 0; a < 3; ++a) sum[3 + a] = turn[a] / group.typical[3 + a];
  return sum;
}

}  // namespace sagitta
