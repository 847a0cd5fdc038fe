#include "problems/structure_checks.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "models/effects/catalogue.h"
#include "problems/input_error.h"

namespace sagitta {
namespace {

// SI, of whatever quantity: beyond, squares of it leave no digit to a metre that is added. Ranges that are narrower are
// the readers' (problems/limits.h).
constexpr double kLargestSi = 1e9;

[[noreturn]] void FailStructure(const std::string& item, const std::string& what, const std::string& hint = "") {
  throw InputError({"", 0, item}, what, hint);
}

std::string Numbered(const char* what, size_t index) { return std::string(what) + " " + std::to_string(index); }

void CheckIsNumber(double value, const std::string& item, const char* what) {
  if (std::abs(value) <= kLargestSi) return;  // false of NaN
  FailStructure(item, std::string(what) + " is no number below 10^9 (SI)");
}

template <typename Values>
void CheckAreNumbers(const Values& values, const std::string& item, const char* what) {
  for (const double value : values) CheckIsNumber(value, item, what);
}

// NaN is what was not measured.
template <typename Values>
void CheckAreNumbersOrNaN(const Values& values, const std::string& item, const char* what) {
  for (const double value : values) {
    if (!std::isnan(value)) CheckIsNumber(value, item, what);
  }
}

// An index into a list of `size`.
void CheckIndex(int index, size_t size, const std::string& item, const char* what) {
  if (index >= 0 && index < static_cast<int>(size)) return;
  FailStructure(item, std::string(what) + " " + std::to_string(index) + " does not exist, there are " +
                          std::to_string(size) + " (numbers begin at 0)");
}

// As many as there are joints, or none.
void CheckOnePerJoint(Eigen::Index count, int joints, const std::string& item, const char* what) {
  if (count == joints) return;
  FailStructure(item, std::to_string(count) + " " + what + ", the robot has " + std::to_string(joints) + " joints");
}

void CheckNamesDiffer(const std::vector<std::string>& names, const char* what) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.empty()) FailStructure(what, "one has no name");
    if (!seen.insert(name).second) FailStructure(what, "two have the name '" + name + "'", "give each its own name");
  }
}

void CheckChain(const Chain& chain) {
  const size_t joints = chain.joints.size();
  if (joints == 0) FailStructure("robot", "it has no joint");
  CheckNamesDiffer(JointNames(chain.joints), "joints of the robot");
  for (size_t e = 0; e < chain.transforms.size(); ++e) {
    const ElementaryTransform& transform = chain.transforms[e];
    const std::string item = Numbered("transform", e);
    if (transform.has_joint()) CheckIndex(transform.joint, joints, item, "joint");
    CheckIsNumber(transform.nominal, item, "its nominal value");
    if (std::abs(transform.sign) != 1.0) FailStructure(item, "its sign is neither 1 nor -1");
  }
  for (size_t c = 0; c < chain.couplings.size(); ++c) {
    const std::string item = Numbered("coupling", c);
    CheckIndex(chain.couplings[c].joint, joints, item, "joint");
    CheckIndex(chain.couplings[c].driver, joints, item, "driver");
    CheckIsNumber(chain.couplings[c].ratio, item, "its ratio");
  }
  const std::string defect = chain.Defect();
  if (!defect.empty()) FailStructure("robot", defect);
}

void CheckElasticity(const Robot& robot) {
  for (size_t c = 0; c < robot.compliances.size(); ++c) {
    const JointCompliance& compliance = robot.compliances[c];
    const std::string item = Numbered("compliance", c);
    CheckIndex(compliance.joint, robot.chain.joints.size(), item, "joint");
    if (compliance.nodes.empty()) FailStructure(item, "it has no value");
    for (const JointCompliance::Node& node : compliance.nodes) {
      CheckIsNumber(node.q, item, "the joint value of a node");
      CheckIsNumber(node.k, item, "its value");
    }
  }
  if (!robot.gravity_compensator) return;
  const GravityCompensator& spring = *robot.gravity_compensator;
  CheckIndex(spring.joint, robot.chain.joints.size(), "gravity compensator", "joint");
  CheckAreNumbers(
      std::vector<double>{spring.L, spring.a_x, spring.a_y, spring.s0, spring.Kc, spring.zero.value_or(0.0)},
      "gravity compensator", "a value");
}

// The name of an effect decides which definition counts: that of the catalogue comes first.
void CheckOwnEffects(const Robot& robot) {
  std::set<std::string> seen;
  for (const EffectDefinition* definition : robot.own_effects) {
    if (definition == nullptr) FailStructure("own effects of the robot", "one is null");
    const std::string item = "own effect '" + definition->name + "'";
    if (FindEffect(definition->name) != nullptr) {
      FailStructure(item, "the catalogue has an effect of this name", "give yours another name");
    }
    if (!seen.insert(definition->name).second) FailStructure(item, "it is listed twice");
    if (definition->parameters == nullptr || definition->apply == nullptr) {
      FailStructure(item, "it lacks `parameters` or `apply`");
    }
  }
}

bool IsPlainNumber(const std::string& text) {
  const std::optional<double> number = SettingAs<double>(text);
  return number && std::abs(*number) < 1e15;
}

// Choices are among those there are, numbers read as such. Joints: CheckJointsOfEffects.
bool SettingFits(const SettingDefinition& setting, const std::string& text) {
  switch (setting.kind) {
    case SettingDefinition::Kind::kInteger:
      return SettingAs<int>(text).has_value();
    case SettingDefinition::Kind::kNumber:
    case SettingDefinition::Kind::kMoment:
      return IsPlainNumber(text);
    case SettingDefinition::Kind::kJoint:
      return true;
    case SettingDefinition::Kind::kChoice:
      return std::find(setting.choices.begin(), setting.choices.end(), text) != setting.choices.end();
  }
  return false;
}

void CheckSettings(const Robot& robot, const EffectDefinition& definition, const EffectSpec& spec) {
  std::vector<std::string> known;
  for (const SettingDefinition& setting : definition.settings) {
    known.push_back(setting.name);
    const auto stated = spec.settings.find(setting.name);
    const bool is_optional = setting.silent || !setting.FallbackFor(robot).empty() || !setting.MeansSomethingFor(spec);
    if (stated == spec.settings.end()) {
      if (!is_optional) FailStructure(spec.Path(), "the setting '" + setting.name + "' is missing");
    } else if (stated->second != setting.FallbackFor(robot) && !SettingFits(setting, stated->second)) {
      FailStructure(spec.Path(), "the setting '" + setting.name + "' cannot be '" + stated->second + "'",
                    setting.choices.empty() ? "" : SpellingHint(stated->second, setting.choices));
    }
  }
  for (const auto& [name, text] : spec.settings) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    FailStructure(spec.Path(), "the effect has no setting '" + name + "'",
                  known.empty() ? "" : SpellingHint(name, known));
  }
}

// Joints that the effect names. Where one is none, CheckJointsOfEffects names the robot's file too.
bool HasItsJoints(const Robot& robot, const EffectDefinition& definition, const EffectSpec& spec) {
  if (definition.target == EffectTarget::kJoint && robot.chain.FindJoint(spec.target) < 0) return false;
  return std::all_of(definition.settings.begin(), definition.settings.end(), [&](const SettingDefinition& setting) {
    const auto stated = spec.settings.find(setting.name);
    const bool names_joint = setting.kind == SettingDefinition::Kind::kJoint && stated != spec.settings.end();
    return !names_joint || robot.chain.FindJoint(stated->second) >= 0;
  });
}

void CheckValues(const Robot& robot, const EffectDefinition& definition, const EffectSpec& spec) {
  const size_t parameters = definition.parameters(robot, spec).size();
  for (const auto* values : {&spec.values, &spec.prior_sigmas}) {
    if (!values->empty() && values->size() != parameters) {
      FailStructure(spec.Path(), std::to_string(values->size()) + " values, the effect has " +
                                     std::to_string(parameters) + " parameters");
    }
    CheckAreNumbers(*values, spec.Path(), "a value");
  }
}

void CheckEffectSpecs(const Robot& robot) {
  std::set<std::string> seen;
  for (const EffectSpec& spec : robot.effects) {
    const EffectDefinition* definition = FindEffect(robot, spec.effect);
    if (definition == nullptr) {
      FailStructure("effects of the robot", "there is no effect '" + spec.effect + "'",
                    SpellingHint(spec.effect, EffectNames(robot)));
    }
    CheckSettings(robot, *definition, spec);
    if (definition->target == EffectTarget::kError && robot.chain.FindError(spec.target) < 0) {
      FailStructure(spec.Path(), "the robot has no geometric error '" + spec.target + "'");
    }
    if (!seen.insert(spec.Path()).second) FailStructure(spec.Path(), "the effect stands twice");
    if (HasItsJoints(robot, *definition, spec)) CheckValues(robot, *definition, spec);
  }
}

void CheckConfigurations(const Measurements& data, int joints) {
  for (const Configuration& configuration : data.configurations) {
    const std::string item = "configuration " + configuration.id;
    CheckOnePerJoint(configuration.q.size(), joints, item, "joint values");
    CheckAreNumbers(configuration.q, item, "a joint value");
  }
}

void CheckShot(const Measurements& data, size_t s, int joints) {
  const Shot& shot = data.shots[s];
  const std::string item = Numbered("shot", s);
  CheckIndex(shot.configuration, data.configurations.size(), item, "configuration");
  CheckIndex(shot.station, data.stations.size(), item, "station");
  if (shot.joint_torques.size() > 0) CheckOnePerJoint(shot.joint_torques.size(), joints, item, "joint torques");
  if (!shot.approach.empty()) {
    CheckOnePerJoint(static_cast<Eigen::Index>(shot.approach.size()), joints, item, "directions of approach");
  }
  for (const int direction : shot.approach) {
    if (direction < -1 || direction > kApproachNotStated) FailStructure(item, "a direction of approach is -1, 0 or 1");
  }
  CheckAreNumbers(shot.joint_torques, item, "a joint torque");
  CheckAreNumbers(shot.wrench.force, item, "its force");
  CheckAreNumbers(shot.wrench.moment, item, "its moment");
  if (shot.has_time && !std::isfinite(shot.time)) FailStructure(item, "its time is no number");
  if (shot.has_temperature) CheckIsNumber(shot.temperature, item, "its temperature");
  for (const int i : shot.observations) {
    CheckIndex(i, data.observations.size(), item, "observation");
    if (data.observations[i].shot != static_cast<int>(s)) {
      FailStructure(
          item, Numbered("it lists observation", i) + ", which is of " + Numbered("shot", data.observations[i].shot));
    }
  }
}

void CheckObservation(const Measurements& data, size_t i, MarkerlessRows markerless) {
  const Observation& row = data.observations[i];
  const std::string item = Numbered("observation", i);
  CheckIndex(row.shot, data.shots.size(), item, "shot");
  const bool is_of_flange = markerless == MarkerlessRows::kAllowed && data.markers.empty() && row.marker < 0;
  if (!is_of_flange) CheckIndex(row.marker, data.markers.size(), item, "marker");
  if (row.file >= 0) {
    CheckIndex(row.file, data.files.size(), item, "file");
    CheckIndex(row.row, data.files[row.file].rows.size(), item, "row of its file");
  }
  if (row.partner >= 0 || !row.is_point()) CheckIndex(row.partner, data.observations.size(), item, "partner");
  CheckAreNumbersOrNaN(row.point_in_station, item, "a coordinate");
  CheckAreNumbers(row.sigma, item, "a standard deviation");
  CheckAreNumbers(row.rotation().sigma, item, "a standard deviation of its rotation");
  if (row.sigma.minCoeff() < 0.0) FailStructure(item, "a standard deviation is negative", "0: none is stated");
}

// Every observation is in the list of its shot, once.
void CheckListed(const Measurements& data) {
  std::vector<int> listed(data.observations.size(), 0);
  for (const Shot& shot : data.shots) {
    for (const int i : shot.observations) ++listed[i];
  }
  for (size_t i = 0; i < listed.size(); ++i) {
    if (listed[i] == 1) continue;
    FailStructure(Numbered("observation", i),
                  (listed[i] == 0 ? "its shot does not list it: " : "its shot lists it more than once: ") +
                      Numbered("shot", data.observations[i].shot),
                  "Shot::observations has each observation of the shot once");
  }
}

}  // namespace

void CheckStructure(const Robot& robot, const Measurements& data, MarkerlessRows markerless) {
  CheckChain(robot.chain);
  CheckElasticity(robot);
  CheckOwnEffects(robot);
  CheckEffectSpecs(robot);
  if (data.observations.empty()) FailStructure("measurements", "there is no row");
  CheckNamesDiffer(data.markers, "markers");
  CheckNamesDiffer(data.stations, "stations");
  CheckConfigurations(data, robot.num_joints());
  for (size_t i = 0; i < data.observations.size(); ++i) CheckObservation(data, i, markerless);
  for (size_t s = 0; s < data.shots.size(); ++s) CheckShot(data, s, robot.num_joints());
  CheckListed(data);
}

}  // namespace sagitta
