#include "estimator/diagnosis/diagnosed_model.h"

#include <glog/logging.h>

#include <algorithm>

#include "estimator/explanations/compensator_shapes.h"
#include "estimator/explanations/typical_units.h"
#include "estimator/least_squares/refit.h"
#include "problems/problem_checks.h"

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

// What a spring acts through is no less than nothing: beyond, another spring would do the same the other way round.
void KeepGivingWay(const std::string& joint, ParameterSet* parameters) {
  const int compliance = parameters->FindCoordinate(ComplianceEffectOf(joint).Path() + "/k");
  if (compliance >= 0 && ComplianceCoordinates(*parameters, joint).empty())
    parameters->coordinate(compliance).lower = 0.0;
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
    if (IsGravityCompensator(candidate.spec) && !IsNewSpring(candidate.spec)) {
      FreeSpring(candidate.rate_alone, candidate.prior_scale, &problem.parameters);
      continue;
    }
    for (const std::string& name : candidate.loose) {
      const int i = problem.parameters.FindCoordinate(name);
      CHECK_GE(i, 0) << name;
      Coordinate& coordinate = problem.parameters.coordinate(i);
      coordinate.free = coordinate.free && sizes[i] > 0.0;  // nothing excites it
      if (coordinate.free) coordinate.prior_sigma = coordinate.effect_prior = candidate.prior_scale * sizes[i];
    }
    if (!IsGravityCompensator(candidate.spec)) continue;
    BoundCompensatorShape(candidate.keeps_shape, &problem.parameters);
    KeepGivingWay(candidate.spec.target, &problem.parameters);
  }
  return problem;
}

}  // namespace

DiagnosedModel FitFully(const CalibrationProblem& problem, const JointOptions& options) {
  CheckRowsAreRead(problem);
  auto own = std::make_shared<CalibrationProblem>(problem);
  return {own, EstimateJointly(*own, options)};
}

DiagnosedModel JudgeFully(std::shared_ptr<CalibrationProblem> problem, const ParameterSet& from,
                          const ParameterSet& aligned, const JointOptions& options) {
  JointOptions near = options;
  near.aligned = &aligned;
  return {problem, EstimateFrom(*problem, from, near)};
}

DiagnosedModel RefitFully(const CalibrationProblem& problem, const Estimate& start, const JointOptions& options) {
  return JudgeFully(std::make_shared<CalibrationProblem>(problem), start.parameters, start.aligned, options);
}

// The step that is left is made without looking again: of a tenth of a standard deviation, what the quadratic model has
// wrong is a share of 1e-2 even where effects bend by a tenth within one deviation.
QuickRefit RefitQuickly(const CalibrationProblem& problem, const ParameterSet& start) {
  RefitOptions options;
  options.steps.max_steps = 40;  // most need two or three; a bent valley halves what is left: 2^-40 = 1e-12
  options.steps.tolerance = 0.1;
  options.steps.least_noise = 1.0;  // as stated
  Refit found = RefitFrom(problem, start, options);
  QuickRefit refit;
  Estimate& estimate = refit.estimate;
  estimate.parameters = std::move(found.parameters);
  if (!found.converged) return refit;
  const Linearization& here = found.linearization;
  estimate.status = Status::kConverged;
  estimate.chi2 = (here.residual + here.jacobian * found.left.delta).squaredNorm();
  estimate.rows = found.equations;
  estimate.dof = found.equations - here.num_columns() + static_cast<int>(found.left.pinned.size());
  refit.sigmas.setZero(estimate.parameters.num_coordinates());
  refit.sigmas(here.columns) = found.left.root.rowwise().norm();
  Move(here.columns, found.left.delta, 1.0, &estimate.parameters);
  return refit;
}

std::vector<ParameterEstimate> ParameterRowsOf(const EffectSpec& spec, const Estimate& estimate) {
  std::vector<ParameterEstimate> rows;
  for (const ParameterEstimate& row : estimate.table) {
    if (!row.free || !IsParameterOf(spec, row.name)) continue;
    rows.push_back(row);
    if (!row.conditional) continue;
    rows.back().sigma = row.unconditional_sigma;
    rows.back().ci95 = row.unconditional_ci95;
  }
  return rows;
}

DiagnosedModel Extend(const DiagnosedModel& model, const std::vector<Candidate>& added, const JointOptions& options) {
  if (added.empty()) return model;
  DiagnosedModel extended;
  extended.problem = std::make_shared<CalibrationProblem>(ExtendedProblem(model, added));
  const ParameterSet& start = extended.problem->parameters;
  QuickRefit quick = RefitQuickly(*extended.problem, start);
  if (!IsUsable(quick.estimate.status)) return JudgeFully(extended.problem, start, start, options);
  // A spring that the data hardly determine is a valley in which a start from nominal creeps.
  if (!DeterminesAll(quick)) return JudgeFully(extended.problem, quick.estimate.parameters, start, options);
  extended.estimate = std::move(quick.estimate);
  return extended;
}

}  // namespace sagitta
