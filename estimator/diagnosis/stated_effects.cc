#include "estimator/diagnosis/stated_effects.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace sagitta {
namespace {

// Chi-square that two explanations with as many parameters may be apart and are both within 95 %: odds of 19 to 1,
// 2 ln 19.
constexpr double kAsGoodAsFound = 5.89;

// Chi-square of the model with the values of a stated effect estimated, too.
double ChiSquareWithFree(const DiagnosedModel& model, const EffectSpec& stated) {
  CalibrationProblem problem = *model.problem;
  problem.parameters = model.estimate.parameters;
  for (int i = 0; i < problem.parameters.num_coordinates(); ++i) {
    Coordinate& coordinate = problem.parameters.coordinate(i);
    if (IsParameterOf(stated, coordinate.name)) coordinate.free = true;
  }
  const QuickRefit refit = RefitQuickly(problem, problem.parameters);
  return IsUsable(refit.estimate.status) ? refit.estimate.chi2 : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<EffectSpec> HeldEffects(const CalibrationProblem& problem) {
  std::vector<EffectSpec> held;
  for (const EffectSpec& spec : problem.robot().effects) {
    const auto& coordinates = problem.parameters.coordinates();
    const bool is_free = std::any_of(coordinates.begin(), coordinates.end(), [&](const Coordinate& coordinate) {
      return coordinate.free && IsParameterOf(spec, coordinate.name);
    });
    if (!is_free) held.push_back(spec);
  }
  return held;
}

std::vector<EffectSpec> StatedInPlaceOf(const DiagnosedModel& lacking, const std::vector<Candidate>& found, size_t k,
                                        const JointOptions& options) {
  std::vector<EffectSpec> alike = HeldEffects(*lacking.problem);
  const auto is_other = [&](const EffectSpec& stated) { return stated.effect != found[k].spec.effect; };
  alike.erase(std::remove_if(alike.begin(), alike.end(), is_other), alike.end());
  if (alike.empty()) return {};
  std::vector<Candidate> others = found;
  others.erase(others.begin() + static_cast<long>(k));
  const DiagnosedModel with = Extend(lacking, found, options), without = Extend(lacking, others, options);
  if (!IsUsable(with.estimate.status) || !IsUsable(without.estimate.status)) return {};
  const double reached = RefitQuickly(*with.problem, with.estimate.parameters).estimate.chi2;
  std::vector<EffectSpec> instead;
  std::copy_if(alike.begin(), alike.end(), std::back_inserter(instead), [&](const EffectSpec& stated) {
    return ChiSquareWithFree(without, stated) <= reached + kAsGoodAsFound;
  });
  return instead;
}

}  // namespace sagitta
