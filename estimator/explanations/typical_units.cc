#include "estimator/explanations/typical_units.h"

#include <algorithm>

#include "models/effects/catalogue.h"
#include "problems/excitation.h"

namespace sagitta {
namespace {

// Most sizes are stated as they are: a pass over the rows is for the others.
bool AnyAsksForMotion(const Robot& robot, const std::vector<EffectSpec>& effects) {
  return std::any_of(effects.begin(), effects.end(), [&](const EffectSpec& spec) {
    const EffectDefinition* definition = FindEffect(robot, spec.effect);
    if (definition == nullptr) return false;
    const std::vector<EffectParameter> own = definition->parameters(robot, spec);
    return std::any_of(own.begin(), own.end(), [](const EffectParameter& parameter) {
      return parameter.of_motion || !(parameter.typical > 0.0);
    });
  });
}

}  // namespace

// size_i = typical_i; as a motion typical_i / max_k m_k; unstated 3e-4 / m_i.
std::vector<double> TypicalSizes(const std::vector<EffectParameter>& of_effect, const std::vector<double>& motions) {
  double most = 0.0;  // of those stated as a motion: a machine of this size
  for (size_t k = 0; k < of_effect.size(); ++k) {
    if (of_effect[k].of_motion) most = std::max(most, motions[k]);
  }
  std::vector<double> sizes(of_effect.size(), 0.0);
  for (size_t k = 0; k < of_effect.size(); ++k) {
    const bool is_stated = of_effect[k].typical > 0.0;
    if (is_stated && !of_effect[k].of_motion) {
      sizes[k] = of_effect[k].typical;
    } else if (motions[k] > 0.0) {
      sizes[k] = is_stated ? of_effect[k].typical / most : kTypicalMotion / motions[k];
    }
  }
  return sizes;
}

std::vector<double> TypicalSizes(const CalibrationProblem& problem, const ParameterSet& parameters,
                                 const std::vector<EffectSpec>& effects) {
  std::vector<double> motions(static_cast<size_t>(parameters.num_coordinates()), 0.0), sizes = motions;
  const std::vector<double> largest =
      AnyAsksForMotion(problem.robot(), effects) ? LargestTrueMotions(problem, parameters) : std::vector<double>();
  for (size_t i = 0; i < largest.size(); ++i) {
    motions[parameters.model_parameter(static_cast<int>(i)).first_coordinate] = largest[i];
  }
  for (const EffectSpec& spec : effects) {
    const EffectDefinition* definition = FindEffect(problem.robot(), spec.effect);
    if (definition == nullptr) continue;
    std::vector<EffectParameter> own;
    std::vector<double> own_motions;
    std::vector<size_t> coordinates;
    for (const EffectParameter& parameter : definition->parameters(problem.robot(), spec)) {
      const int coordinate = parameters.FindCoordinate(spec.Path() + "/" + parameter.name);
      if (coordinate < 0) continue;
      coordinates.push_back(static_cast<size_t>(coordinate));
      own.push_back(parameter);
      own_motions.push_back(motions[coordinates.back()]);
    }
    const std::vector<double> own_sizes = TypicalSizes(own, own_motions);
    for (size_t k = 0; k < own.size(); ++k) sizes[coordinates[k]] = own_sizes[k];
  }
  return sizes;
}

}  // namespace sagitta
