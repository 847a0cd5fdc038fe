#include "estimator/calibration/load_centres.h"

#include <optional>

#include "estimator/report/calibration_words.h"
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

std::optional<double> ValueOf(const ParameterSet& parameters, const EffectDefinition& effect, const std::string& load,
                              const std::string& parameter) {
  const int coordinate = parameters.FindCoordinate(EffectSpec{effect.name, load, {}, {}}.Path() + "/" + parameter);
  return coordinate < 0 ? std::nullopt : std::optional<double>(parameters.Value(coordinate));
}

// kg, of the first shot with this load; 0: none.
double StatedMass(const CalibrationProblem& problem, const std::string& load) {
  for (const ShotInput& shot : problem.shot_inputs()) {
    const ShotConditions& conditions = shot.conditions;
    if (conditions.load != load || conditions.load_wrenches.empty()) continue;
    return conditions.load_wrenches.front().force.norm() / conditions.gravity.norm();
  }
  return 0.0;
}

}  // namespace

std::vector<std::string> LoadCentresInWords(const CalibrationProblem& problem, const ParameterSet& parameters) {
  std::vector<std::string> words;
  for (const EffectSpec& effect : problem.robot().effects) {
    if (!IsUseOf(LoadCom(), effect)) continue;
    const std::optional<double> more = ValueOf(parameters, Payload(), effect.target, "dmass");
    const double mass = StatedMass(problem, effect.target);
    if (!more || *more == 0.0 || !(mass + *more > 0.0)) continue;
    Vector3<double> off;
    for (int axis = 0; axis < 3; ++axis) {
      off[axis] = ValueOf(parameters, LoadCom(), effect.target, std::string("d") + "xyz"[axis]).value_or(0.0);
    }
    words.push_back(CentreOfHeavierLoad(effect.target, mass + *more, mass / (mass + *more) * off));
  }
  return words;
}

}  // namespace sagitta
