#include "estimator/explanations/typical_units.h"

#include <algorithm>
#include <map>

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

// Parameters of an effect that the model has, and by how much one unit of each moves anything.
struct MovedParameters {
  const EffectDefinition* definition = nullptr;
  std::vector<EffectParameter> parameters;
  std::vector<double> motions;
  std::vector<size_t> coordinates;
};

MovedParameters MovedParametersOf(const Robot& robot, const ParameterSet& parameters,
                                  const std::vector<double>& motions, const EffectSpec& spec) {
  MovedParameters moved;
  moved.definition = FindEffect(robot, spec.effect);
  if (moved.definition == nullptr) return moved;
  for (const EffectParameter& parameter : moved.definition->parameters(robot, spec)) {
    const int coordinate = parameters.FindCoordinate(spec.Path() + "/" + parameter.name);
    if (coordinate < 0) continue;
    moved.coordinates.push_back(static_cast<size_t>(coordinate));
    moved.parameters.push_back(parameter);
    moved.motions.push_back(motions[moved.coordinates.back()]);
  }
  return moved;
}

}  // namespace

// size_i = typical_i; as a motion typical_i / max_k m_k; unstated 3e-4 / m_i.
std::vector<double> TypicalSizes(const std::vector<EffectParameter>& of_effect, const std::vector<double>& motions,
                                 double most_of_targets) {
  double most = most_of_targets;  // of those stated as a motion: a machine of this size
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
  std::vector<MovedParameters> moved;
  std::map<const EffectDefinition*, double> most;  // of each effect that has one size on all targets
  for (const EffectSpec& spec : effects) {
    moved.push_back(MovedParametersOf(problem.robot(), parameters, motions, spec));
    if (moved.back().definition == nullptr || !moved.back().definition->one_size) continue;
    double& of_targets = most[moved.back().definition];
    for (const double motion : moved.back().motions) of_targets = std::max(of_targets, motion);
  }
  for (const MovedParameters& own : moved) {
    const auto of_targets = most.find(own.definition);
    const std::vector<double> own_sizes =
        TypicalSizes(own.parameters, own.motions, of_targets == most.end() ? 0.0 : of_targets->second);
    for (size_t k = 0; k < own_sizes.size(); ++k) sizes[own.coordinates[k]] = own_sizes[k];
  }
  return sizes;
}

}  // namespace sagitta
