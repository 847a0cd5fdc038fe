#include "problems/io/effect_names.h"

#include <algorithm>

#include "models/effects/catalogue.h"
#include "problems/calibration_problem.h"
#include "problems/input_error.h"
#include "problems/io/effect_entries.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr const char* kEffectNameHint =
    "EFFECT/TARGET or EFFECT[SETTING=VALUE,…]/TARGET, for example joint_harmonic[order=1]/A3";

// As a robot file would state them: their values are checked as there.
void CheckNamedSettings(const EffectDefinition& definition, const Robot& robot, const std::string& key,
                        EffectSpec* spec) {
  YAML::Node entry(YAML::NodeType::Map);
  for (const auto& [name, value] : spec->settings) entry[name] = value;
  YamlMap map(YamlValue(entry, "", key, 0));
  spec->settings.clear();
  ReadSettings(definition, robot, &map, spec);
}

// joint_harmonic[order=2]/A3, as results name it.
EffectSpec EffectNamed(const Robot& robot, const std::string& text, const std::string& key) {
  const size_t slash = text.rfind('/');
  if (slash == std::string::npos) {
    throw InputError({"", 0, key}, "'" + text + "' does not say what the effect acts on", kEffectNameHint);
  }
  EffectSpec spec;
  spec.effect = text.substr(0, slash);
  spec.target = text.substr(slash + 1);
  const size_t open = spec.effect.find('[');
  if (open != std::string::npos) {
    if (spec.effect.back() != ']') throw InputError({"", 0, key}, "'" + text + "' lacks a ']'", kEffectNameHint);
    for (const std::string& setting : SplitText(spec.effect.substr(open + 1, spec.effect.size() - open - 2), ',')) {
      const size_t equals = setting.find('=');
      if (equals == std::string::npos) {
        throw InputError({"", 0, key}, "'" + setting + "' is no setting", kEffectNameHint);
      }
      const std::string name = setting.substr(0, equals);
      if (!spec.settings.emplace(name, setting.substr(equals + 1)).second) {
        throw InputError({"", 0, key}, "'" + text + "' states '" + name + "' twice", kEffectNameHint);
      }
    }
    spec.effect.resize(open);
  }
  const EffectDefinition* definition = FindEffect(robot, spec.effect);
  if (IsGravityCompensator(spec)) {
    throw InputError({"", 0, key}, "what a gravity compensator does goes with where its ends are, which no name says",
                     "state it in the robot file (gravity_compensator: …): its parameters are then in the plan");
  }
  if (definition == nullptr) {
    throw InputError({"", 0, key}, "there is no effect '" + spec.effect + "' to plan for", kEffectNameHint);
  }
  for (const auto& [name, value] : spec.settings) {
    const bool is_known = std::any_of(definition->settings.begin(), definition->settings.end(),
                                      [&name = name](const SettingDefinition& known) { return known.name == name; });
    if (!is_known) {
      throw InputError({"", 0, key}, spec.effect + " has no setting '" + name + "'", kEffectNameHint);
    }
  }
  for (const SettingDefinition& setting : definition->settings) {
    const bool needed = setting.fallback.empty() && setting.fallback_of == nullptr && setting.MeansSomethingFor(spec);
    if (needed && spec.settings.count(setting.name) == 0) {
      throw InputError({"", 0, key}, spec.effect + " needs the setting '" + setting.name + "'", kEffectNameHint);
    }
  }
  CheckNamedSettings(*definition, robot, key, &spec);
  if (definition->target == EffectTarget::kJoint && robot.chain.FindJoint(spec.target) < 0) {
    throw InputError({"", 0, key}, "the robot has no joint '" + spec.target + "'", kEffectNameHint);
  }
  if (definition->target == EffectTarget::kError && robot.chain.FindError(spec.target) < 0) {
    throw InputError({"", 0, key}, "the robot has no error '" + spec.target + "'", kEffectNameHint);
  }
  return spec;
}

}  // namespace

std::vector<std::string> SplitOutsideBrackets(const std::string& text) {
  std::vector<std::string> parts = {""};
  int depth = 0;
  for (const char c : text) {
    depth += c == '[' ? 1 : c == ']' ? -1 : 0;
    if (c == ',' && depth == 0) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

std::vector<EffectSpec> RivalEffects(const Robot& robot, const std::string& names, const std::string& key) {
  if (names.empty()) return {};
  std::vector<EffectSpec> rivals;
  for (const std::string& name : SplitOutsideBrackets(names)) rivals.push_back(EffectNamed(robot, name, key));
  for (size_t i = 1; i < rivals.size(); ++i) {
    if (rivals[i].Path() != rivals[0].Path()) continue;
    throw InputError({"", 0, key}, "an effect cannot be distinguished from itself", "name two different ones");
  }
  if (rivals.size() < 2) {
    throw InputError({"", 0, key}, "two effects are expected", "EFFECT/TARGET,EFFECT/TARGET");
  }
  return rivals;
}

}  // namespace sagitta
