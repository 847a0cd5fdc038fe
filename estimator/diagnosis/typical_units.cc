#include "estimator/diagnosis/typical_units.h"

#include "models/effects/catalogue.h"
#include "problems/excitation.h"

namespace sagitta {

std::vector<double> TypicalSizes(const CalibrationProblem& problem, const ParameterSet& parameters) {
  std::vector<double> motions(static_cast<size_t>(parameters.num_coordinates()), 0.0), sizes = motions;
  const std::vector<double> largest = LargestTrueMotions(problem, parameters);
  for (size_t i = 0; i < largest.size(); ++i) {
    motions[static_cast<size_t>(parameters.model_parameter(static_cast<int>(i)).first_coordinate)] = largest[i];
  }
  for (const EffectSpec& spec : problem.robot.effects) {
    const EffectDefinition* definition = FindEffect(problem.robot, spec.effect);
    if (definition == nullptr) continue;
    for (const EffectParameter& parameter : definition->parameters(problem.robot, spec)) {
      const int found = parameters.FindCoordinate(spec.Path() + "/" + parameter.name);
      if (found < 0) continue;
      const size_t i = static_cast<size_t>(found);
      const bool is_stated = parameter.typical > 0.0;
      if (is_stated && !parameter.of_motion) {
        sizes[i] = parameter.typical;
      } else if (motions[i] > 0.0) {
        sizes[i] = (is_stated ? parameter.typical : kTypicalMotion) / motions[i];
      }
    }
  }
  return sizes;
}

}  // namespace sagitta
