#include "estimator/diagnosis/typical_units.h"

#include <algorithm>

#include "models/effects/catalogue.h"
#include "problems/excitation.h"

namespace sagitta {

// size_i = typical_i; as a motion typical_i / max_k m_k; unstated 3e-4 / m_i;  m_i: motion per unit where the rows
// excite i most.
std::vector<double> TypicalSizes(const CalibrationProblem& problem, const ParameterSet& parameters) {
  std::vector<double> motions(static_cast<size_t>(parameters.num_coordinates()), 0.0), sizes = motions;
  const std::vector<double> largest = LargestTrueMotions(problem, parameters);
  for (size_t i = 0; i < largest.size(); ++i) {
    motions[static_cast<size_t>(parameters.model_parameter(static_cast<int>(i)).first_coordinate)] = largest[i];
  }
  for (const EffectSpec& spec : problem.robot().effects) {
    const EffectDefinition* definition = FindEffect(problem.robot(), spec.effect);
    if (definition == nullptr) continue;
    const std::vector<EffectParameter> own = definition->parameters(problem.robot(), spec);
    const auto find = [&](const EffectParameter& parameter) {
      return parameters.FindCoordinate(spec.Path() + "/" + parameter.name);
    };
    double most = 0.0;  // of those stated as a motion: a machine of this size
    for (const EffectParameter& parameter : own) {
      if (parameter.of_motion && find(parameter) >= 0) most = std::max(most, motions[find(parameter)]);
    }
    for (const EffectParameter& parameter : own) {
      if (find(parameter) < 0) continue;
      const size_t i = static_cast<size_t>(find(parameter));
      const bool is_stated = parameter.typical > 0.0;
      if (is_stated && !parameter.of_motion) {
        sizes[i] = parameter.typical;
      } else if (motions[i] > 0.0) {
        sizes[i] = is_stated ? parameter.typical / most : kTypicalMotion / motions[i];
      }
    }
  }
  return sizes;
}

}  // namespace sagitta
