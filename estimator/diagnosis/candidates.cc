#include "estimator/diagnosis/candidates.h"

#include <algorithm>
#include <set>

#include "models/effects/catalogue.h"
#include "problems/loads.h"

namespace sagitta {
namespace {

constexpr int kHarmonicOrders = 6;        // scanned with few configurations
constexpr int kMostHarmonicOrders = 130;  // a strain wave gear has about 100
constexpr int kConfigurationsPerOrder = 20;
constexpr int kWobbleOrders = 2;
constexpr int kMostChangePoints = 80;

bool AnyLoad(const CalibrationProblem& problem) {
  return std::any_of(problem.shot_inputs.begin(), problem.shot_inputs.end(),
                     [](const ShotInput& shot) { return !shot.wrenches.empty(); });
}

// Elastic parts can only answer to torques.
bool NeedsLoad(const std::string& effect) {
  return effect == "joint_compliance" || effect == "compliance_hardening" || effect == "transverse_compliance" ||
         effect == "base_compliance" || effect == "payload";
}

std::vector<std::string> Targets(const EffectDefinition& definition, const CalibrationProblem& problem) {
  std::vector<std::string> targets;
  switch (definition.target) {
    case EffectTarget::kJoint:
      for (const Joint& joint : problem.robot.chain.joints) {
        if (joint.type == JointType::kRevolute) targets.push_back(joint.name);
      }
      break;
    case EffectTarget::kError:
      for (const Coordinate& coordinate : problem.parameters.coordinates()) {
        if (coordinate.name.rfind("geometry/", 0) == 0 && !coordinate.estimated())
          targets.push_back(coordinate.name.substr(9));
      }
      break;
    case EffectTarget::kBase:
      targets = {"base"};
      break;
    case EffectTarget::kRobot:
      targets = {"robot"};
      break;
    case EffectTarget::kStation:
      targets = problem.data.stations;
      break;
    case EffectTarget::kLoad: {
      std::set<std::string> loads;
      for (const Shot& shot : problem.data.shots) {
        if (IsLoaded(shot)) loads.insert(shot.load);
      }
      targets.assign(loads.begin(), loads.end());
      break;
    }
    case EffectTarget::kMarker:
      targets = problem.data.markers;
      break;
  }
  return targets;
}

// Middles between the times of consecutive visits, thinned.
std::vector<std::string> ChangePoints(const CalibrationProblem& problem) {
  std::set<double> times;
  for (size_t s = 0; s < problem.shot_inputs.size(); ++s) {
    const bool held_out = problem.data.configurations[problem.data.shots[s].configuration].is_validation;
    if (problem.shot_inputs[s].conditions.has_time && !held_out) times.insert(problem.shot_inputs[s].conditions.time);
  }
  const std::vector<double> sorted(times.begin(), times.end());
  std::vector<std::string> points;
  const size_t stride = std::max<size_t>(1, sorted.size() / kMostChangePoints);
  for (size_t i = stride; i + 1 < sorted.size(); i += stride) {
    points.push_back(std::to_string(0.5 * (sorted[i - 1] + sorted[i])));
  }
  return points;
}

// As many orders as the configurations can resolve.
int HarmonicOrders(const CalibrationProblem& problem) {
  const auto& configurations = problem.data.configurations;
  const auto fitted = std::count_if(configurations.begin(), configurations.end(),
                                    [](const Configuration& c) { return !c.is_validation; });
  return std::min(kMostHarmonicOrders, std::max(kHarmonicOrders, static_cast<int>(fitted) / kConfigurationsPerOrder));
}

std::vector<std::string> Choices(const SettingDefinition& setting, const EffectDefinition& definition,
                                 const std::string& target, const CalibrationProblem& problem) {
  std::vector<std::string> choices;
  switch (setting.kind) {
    case SettingDefinition::Kind::kInteger:
      for (int n = 1; n <= (definition.name == "axis_wobble" ? kWobbleOrders : HarmonicOrders(problem)); ++n) {
        choices.push_back(std::to_string(n));
      }
      break;
    case SettingDefinition::Kind::kNumber:
      choices = ChangePoints(problem);
      break;
    case SettingDefinition::Kind::kJoint:
      for (const Joint& joint : problem.robot.chain.joints) {
        if (joint.name != target) choices.push_back(joint.name);
      }
      break;
    case SettingDefinition::Kind::kChoice:
      choices = setting.choices;
      break;
  }
  return choices;
}

bool Stands(const CalibrationProblem& problem, const EffectSpec& spec) {
  for (const EffectSpec& own : problem.robot.effects) {
    if (own.Path() == spec.Path()) return true;
  }
  if (spec.effect != "joint_compliance") return false;
  for (const int i : problem.parameters.Match("compliance/" + spec.target)) {
    if (problem.parameters.coordinates()[i].estimated()) return true;
  }
  return false;
}

std::string Missing(const CalibrationProblem& problem, const EffectDefinition& definition, const EffectSpec& spec) {
  for (const ShotInput& shot : problem.shot_inputs) {
    const EffectContext context{&problem.robot, &spec, &shot.conditions, &problem.data.markers, 0};
    const std::string column = definition.missing(context);
    if (!column.empty()) return column;
  }
  return "";
}

// The compensator's home is the robot; its place in the list of effects is after
// the transverse compliance.
void AppendCompensators(const CalibrationProblem& problem, CandidateList* list) {
  if (problem.robot.gravity_compensator) return;
  std::set<std::string> compliant;
  for (const JointCompliance& compliance : problem.robot.compliances) {
    compliant.insert(problem.robot.chain.joints[compliance.joint].name);
  }
  for (const Joint& joint : problem.robot.chain.joints) {
    if (joint.type != JointType::kRevolute) continue;
    if (compliant.count(joint.name) == 0) {
      list->not_testable.push_back({"gravity_compensator", joint.name, "the joint's compliance (loaded rows)"});
    } else {
      list->candidates.push_back({{"gravity_compensator", joint.name, {}, {}}, 1, 0, {}});
    }
  }
}

}  // namespace

std::vector<EffectSpec> SpecsOf(const std::vector<Candidate>& candidates) {
  std::vector<EffectSpec> specs;
  for (const Candidate& candidate : candidates) specs.push_back(candidate.spec);
  return specs;
}

CandidateList ListCandidates(const CalibrationProblem& problem) {
  CandidateList list;
  const bool loaded = AnyLoad(problem);
  const bool elastic = !problem.robot.compliances.empty();
  for (const EffectDefinition* known : EffectsOf(problem.robot)) {
    const EffectDefinition& definition = *known;
    if (definition.name == "link_gravity") AppendCompensators(problem, &list);
    // Sag with unknown compliance stands for link weights where no load tells.
    if (definition.name == "self_weight_sag" && elastic) continue;
    for (const std::string& target : Targets(definition, problem)) {
      EffectSpec spec{definition.name, target, {}, {}};
      if (NeedsLoad(definition.name) && !loaded) {
        list.not_testable.push_back({definition.name, target, "loaded rows"});
        continue;
      }
      if (definition.name == "link_gravity" && !elastic) {
        list.not_testable.push_back({definition.name, target, "joint compliances (loaded rows)"});
        continue;
      }
      std::vector<EffectSpec> variants = {spec};
      for (const SettingDefinition& setting : definition.settings) {
        std::vector<EffectSpec> grown;
        for (const std::string& choice : Choices(setting, definition, target, problem)) {
          for (EffectSpec variant : variants) {
            variant.settings[setting.name] = choice;
            grown.push_back(variant);
          }
        }
        variants = std::move(grown);
      }
      std::string missing = variants.empty() ? Missing(problem, definition, spec) : "";
      std::vector<EffectSpec> testable;
      for (const EffectSpec& variant : variants) {
        const std::string column = Missing(problem, definition, variant);
        if (!column.empty()) missing = column;
        const bool needs_torque = variant.TextSetting("by", "") == "torque" && !loaded;
        if (column.empty() && !needs_torque && !Stands(problem, variant)) testable.push_back(variant);
      }
      if (!missing.empty()) list.not_testable.push_back({definition.name, target, missing});
      for (const EffectSpec& variant : testable) {
        list.candidates.push_back({variant, static_cast<int>(testable.size()), 0, {}});
      }
    }
  }
  for (size_t i = 0; i < list.candidates.size(); ++i) list.candidates[i].place = static_cast<int>(i);
  return list;
}

}  // namespace sagitta
