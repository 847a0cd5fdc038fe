#include "estimator/diagnosis/refit.h"

#include <algorithm>

#include "estimator/explanations/compensator_shapes.h"
#include "estimator/explanations/typical_units.h"
#include "estimator/random_effects/evidence_score.h"

namespace sagitta {
namespace {

// Whether nothing new has become so uncertain that the full estimator would hold it.
bool DeterminesAll(const QuickRefit& refit) {
  const ParameterSet& parameters = refit.estimate.parameters;
  for (const int i : parameters.EstimatedCoordinates()) {
    if (refit.sigmas[i] > parameters.coordinates()[i].hold_limit) return false;
  }
  return true;
}

// The problem with these effects; what the data determine poorly of them (Candidate::loose) has its widest prior.
CalibrationProblem ExtendedProblem(const DiagnosedModel& model, const std::vector<Candidate>& added) {
  CalibrationProblem believed = *model.problem;
  believed.parameters.CopyByName(model.estimate.parameters);
  CalibrationProblem problem = believed.WithEffects(SpecsOf(added));
  const bool any_loose =
      std::any_of(added.begin(), added.end(), [](const Candidate& candidate) { return !candidate.loose.empty(); });
  const std::vector<double> sizes =
      any_loose ? TypicalSizes(problem, problem.parameters, SpecsOf(added)) : std::vector<double>();
  for (const Candidate& candidate : added) {
    for (const std::string& name : candidate.loose) {
      const int i = problem.parameters.FindCoordinate(name);
      Coordinate& coordinate = problem.parameters.coordinate(i);
      coordinate.free = coordinate.free && sizes[i] > 0.0;  // nothing excites it
      if (coordinate.free) coordinate.prior_sigma = candidate.prior_scale * sizes[i];
    }
  }
  for (const Candidate& candidate : added) {
    if (IsGravityCompensator(candidate.spec)) BoundCompensatorShape(candidate.keeps_shape, &problem.parameters);
  }
  return problem;
}

}  // namespace

bool IsParameterOf(const EffectSpec& spec, const std::string& name) {
  const std::string home = IsGravityCompensator(spec) ? "compensator" : spec.Path();
  return name.rfind(home + "/", 0) == 0;
}

DiagnosedModel Extend(const DiagnosedModel& model, const std::vector<Candidate>& added, const JointOptions& options) {
  if (added.empty()) return model;
  DiagnosedModel extended;
  extended.problem = std::make_shared<CalibrationProblem>(ExtendedProblem(model, added));
  const ParameterSet& start = extended.problem->parameters;
  QuickRefit quick = RefitQuickly(*extended.problem, start);
  if (!IsUsable(quick.estimate.status) || !DeterminesAll(quick)) {
    return JudgeFully(extended.problem, start, start, options);
  }
  extended.estimate = std::move(quick.estimate);
  return extended;
}

}  // namespace sagitta
