#include "problems/robot_structure.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "models/effects/catalogue.h"
#include "problems/structure_failure.h"

namespace sagitta {
namespace {

constexpr double kRoundOffOfCorrections =
    1e-9;  // m or rad: of a table and a chain that were corrected by the same sums

void CheckJoints(const Chain& chain) {
  if (chain.joints.empty()) FailStructure("robot", "it has no joint");
  CheckNamesDiffer(JointNames(chain.joints), "joints of the robot");
  for (const Joint& joint : chain.joints) {
    const std::string item = "joint " + joint.name;
    for (const std::optional<double>& end : {joint.min, joint.max}) {
      if (end) CheckIsNumber(*end, item, "a limit");
    }
    if (joint.min && joint.max && *joint.min > *joint.max)
      FailStructure(item, "its lower limit is above the upper one");
  }
}

void CheckCouplings(const Chain& chain) {
  for (size_t c = 0; c < chain.couplings.size(); ++c) {
    const Coupling& coupling = chain.couplings[c];
    const ItemName item("coupling", c);
    CheckIndex(coupling.joint, chain.joints.size(), item, "joint");
    CheckIndex(coupling.driver, chain.joints.size(), item, "driver");
    CheckIsNumber(coupling.ratio, item, "its ratio");
    if (coupling.joint == coupling.driver) FailStructure(item, "a joint cannot drive itself");
    if (chain.joints[coupling.joint].type != chain.joints[coupling.driver].type) {
      FailStructure(item, "a coupling joins two revolute or two prismatic joints");
    }
    for (size_t other = 0; other < c; ++other) {
      if (chain.couplings[other].joint == coupling.joint && chain.couplings[other].driver == coupling.driver)
        FailStructure(item, "an earlier one joins the same joints: the two would add up");
    }
  }
}

void CheckChain(const Chain& chain) {
  CheckJoints(chain);
  const size_t joints = chain.joints.size();
  for (size_t e = 0; e < chain.transforms.size(); ++e) {
    const ElementaryTransform& transform = chain.transforms[e];
    const ItemName item("transform", e);
    if (transform.has_joint()) CheckIndex(transform.joint, joints, item, "joint");
    CheckIsNumber(transform.nominal, item, "its nominal value");
    if (std::abs(transform.sign) != 1.0) FailStructure(item, "its sign is neither 1 nor -1");
  }
  CheckCouplings(chain);
  const std::string defect = chain.Defect();
  if (!defect.empty()) FailStructure("robot", defect);
}

// The table is what is written where a robot has one; the chain is what is calibrated.
void CheckTable(const Robot& robot) {
  if (!robot.dh) return;
  for (const DhLink& link : robot.dh->links) CheckIndex(link.joint, robot.chain.joints.size(), "Robot::dh", "joint");
  const Chain of_table = ChainFromDhTable(robot.chain.joints, robot.chain.couplings, *robot.dh);
  std::vector<ElementaryTransform> own;
  for (const ElementaryTransform& transform : robot.chain.transforms) {
    if (!transform.tilt_slot) own.push_back(transform);
  }
  const auto alike = [](const ElementaryTransform& one, const ElementaryTransform& other) {
    return one.motion == other.motion && one.axis == other.axis && one.joint == other.joint && one.sign == other.sign &&
           one.error == other.error && std::abs(one.nominal - other.nominal) < kRoundOffOfCorrections;
  };
  if (std::equal(own.begin(), own.end(), of_table.transforms.begin(), of_table.transforms.end(), alike)) return;
  FailStructure("Robot::dh", "the chain is not that of the table",
                "change the table and make the chain of it (ChainFromDhTable), or reset dh");
}

void CheckNodes(const JointCompliance& compliance, const ItemName& item) {
  if (compliance.nodes.empty()) FailStructure(item, "it has no value");
  if (!compliance.is_table && compliance.nodes.size() > 1) FailStructure(item, "it has several values and is no table");
  for (size_t n = 0; n < compliance.nodes.size(); ++n) {
    CheckIsNumber(compliance.nodes[n].q, item, "the joint value of a node");
    CheckIsNumber(compliance.nodes[n].k, item, "its value");
    if (compliance.nodes[n].k < 0.0) FailStructure(item, "a compliance is not below 0", "0 is rigid");
    if (n == 0 || compliance.nodes[n - 1].q < compliance.nodes[n].q) continue;
    FailStructure(item, "the joint values of a table have to increase");
  }
}

// Of values, or none; 0: no prior about that one.
void CheckPriorSigmas(const std::vector<double>& sigmas, size_t values, const std::string& item) {
  if (!sigmas.empty() && sigmas.size() != values) {
    FailStructure(item, std::to_string(sigmas.size()) + " standard deviations of priors, there are " +
                            std::to_string(values) + " values");
  }
  CheckAreNumbers(sigmas, item, "the standard deviation of a prior");
  if (std::any_of(sigmas.begin(), sigmas.end(), [](double sigma) { return sigma < 0.0; })) {
    FailStructure(item, "the standard deviation of a prior is negative", "0: no prior");
  }
}

void CheckCompensatorStructure(const Robot& robot) {
  if (!robot.gravity_compensator) return;
  const GravityCompensator& spring = *robot.gravity_compensator;
  const std::vector<double> values = {spring.L, spring.a_x, spring.a_y, spring.s0, spring.Kc};
  const std::string item = "gravity compensator";
  CheckIndex(spring.joint, robot.chain.joints.size(), item, "joint");
  CheckAreNumbers(values, item, "a value");
  CheckIsNumber(spring.zero.value_or(0.0), item, "its zero");
  CheckPriorSigmas(spring.prior_sigmas, values.size(), item);
}

void CheckElasticity(const Robot& robot) {
  std::set<int> compliant;
  for (size_t c = 0; c < robot.compliances.size(); ++c) {
    const JointCompliance& compliance = robot.compliances[c];
    const ItemName item("compliance", c);
    CheckIndex(compliance.joint, robot.chain.joints.size(), item, "joint");
    CheckNodes(compliance, item);
    if (compliant.insert(compliance.joint).second) continue;
    FailStructure(item, "joint '" + robot.chain.joints[compliance.joint].name + "' has two compliances");
  }
  CheckCompensatorStructure(robot);
}

bool IsPlainNumber(const std::string& text) {
  const std::optional<double> number = SettingAs<double>(text);
  return number && std::abs(*number) < 1e15;
}

// Choices are among those there are, numbers read as such. Joints: CheckJointsOfEffects.
bool SettingFits(const SettingDefinition& setting, const std::string& text) {
  switch (setting.kind) {
    case SettingDefinition::Kind::kInteger: {
      const std::optional<int> number = SettingAs<int>(text);
      return number && *number >= setting.least && *number <= setting.most;
    }
    case SettingDefinition::Kind::kNumber:
    case SettingDefinition::Kind::kMoment:
      return IsPlainNumber(text) && *SettingAs<double>(text) > setting.above;
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

const EffectDefinition& DefinitionOf(const Robot& robot, const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (definition != nullptr) return *definition;
  FailStructure("effects of the robot", "there is no effect '" + spec.effect + "'",
                SpellingHint(spec.effect, EffectNames(robot)));
}

void CheckValues(const Robot& robot, const EffectDefinition& definition, const EffectSpec& spec) {
  if (!HasItsJoints(robot, definition, spec)) return;
  const std::string slides = JointThatSlides(robot.chain, definition, spec);
  if (!slides.empty()) FailStructure(spec.Path(), IsForJointsThatTurn(slides));
  const size_t parameters = definition.parameters(robot, spec).size();
  if (!spec.values.empty() && spec.values.size() != parameters) {
    FailStructure(spec.Path(), std::to_string(spec.values.size()) + " values, the effect has " +
                                   std::to_string(parameters) + " parameters");
  }
  CheckAreNumbers(spec.values, spec.Path(), "a value");
  CheckPriorSigmas(spec.prior_sigmas, parameters, spec.Path());
}

}  // namespace

// The name of an effect decides which definition counts: that of the catalogue comes first.
void CheckOwnEffects(const std::vector<const EffectDefinition*>& own_effects) {
  std::set<std::string> seen;
  for (const EffectDefinition* definition : own_effects) {
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

std::string IsForJointsThatTurn(const std::string& sliding_joint) {
  return "'" + sliding_joint + "' slides, and the effect and its units are those of joints that turn";
}

void CheckEffectsAreThere(const Robot& robot) {
  for (const EffectSpec& spec : robot.effects) CheckValues(robot, DefinitionOf(robot, spec), spec);
}

void CheckEffectSpecs(const Robot& robot) {
  std::set<std::string> seen;
  for (const EffectSpec& spec : robot.effects) {
    const EffectDefinition& definition = DefinitionOf(robot, spec);
    CheckSettings(robot, definition, spec);
    if (definition.target == EffectTarget::kError && robot.chain.FindError(spec.target) < 0) {
      FailStructure(spec.Path(), "the robot has no geometric error '" + spec.target + "'");
    }
    if (!seen.insert(spec.Path()).second) FailStructure(spec.Path(), "the effect stands twice");
    CheckValues(robot, definition, spec);
  }
}

void CheckRobotStructure(const Robot& robot) {
  CheckChain(robot.chain);
  CheckTable(robot);
  CheckElasticity(robot);
  CheckOwnEffects(robot.own_effects);
  CheckEffectSpecs(robot);
}

}  // namespace sagitta
