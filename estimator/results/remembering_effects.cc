#include "estimator/results/remembering_effects.h"

#include <algorithm>

#include "estimator/results/estimate_json.h"
#include "models/effects/catalogue.h"
#include "problems/calibration_problem.h"

namespace sagitta {
namespace {

template <typename IsAsked>
std::vector<std::string> PathsOf(const KnownRobot& known, const IsAsked& is_asked) {
  std::vector<std::string> paths;
  for (const EffectSpec& spec : known.robot.effects) {
    const EffectDefinition& definition = *FindEffect(known.robot, spec.effect);
    if (!is_asked(definition) || !CarriesOn(definition, spec)) continue;
    const bool acts = std::any_of(known.parameters.begin(), known.parameters.end(), [&spec](const auto& parameter) {
      return IsParameterOf(spec, parameter.first) && parameter.second.value != 0.0;
    });
    if (acts) paths.push_back(spec.Path());
  }
  return paths;
}

}  // namespace

bool MovesTheArm(const EffectDefinition& effect) {
  return effect.target != EffectTarget::kStation && effect.target != EffectTarget::kMarker;
}

std::vector<std::string> RememberingEffects(const KnownRobot& known) {
  return PathsOf(known, [](const EffectDefinition&) { return true; });
}

std::vector<std::string> RememberingEffectsOfTheArm(const KnownRobot& known) { return PathsOf(known, MovesTheArm); }

}  // namespace sagitta
