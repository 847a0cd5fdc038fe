#include "estimator/diagnosis/selection.h"

#include <algorithm>
#include <cmath>

#include "estimator/distributions.h"

namespace sagitta {
namespace {

int NumParameters(const DiagnosedModel& model, const EffectSpec& spec) {
  int count = 0;
  for (const int i : model.estimate.parameters.Match(spec.Path())) {
    count += model.estimate.parameters.coordinates()[i].estimated();
  }
  return count;
}

double Penalty(const DiagnosedModel& baseline, int parameters, int settings) {
  return parameters * std::log(static_cast<double>(baseline.estimate.rows)) +
         2.0 * std::log(static_cast<double>(settings));
}

// Significance in units of the scatter that is left: a model that does not
// reach the stated sigma cannot use it as yardstick.
double CorrectedP(double reduction, int parameters, const Estimate& after, int tests) {
  const double left = after.dof > 0 ? std::max(1.0, after.chi2 / after.dof) : 1.0;
  return std::min(1.0, tests * ChiSquareSurvival(reduction / left, std::max(1, parameters)));
}

struct Trial {
  ChosenStep step;
  DiagnosedModel model;
};

// Refits the best of the screening and picks by FORMATS section 6; false when
// nothing is significant.
bool PickStep(const DiagnosedModel& model, const std::vector<Candidate>& candidates, const SelectionOptions& options,
              Trial* picked) {
  const std::vector<ScreenedCandidate> screened = Screen(model, candidates, options.most_tests);
  const int tests = std::min<int>(options.most_tests, static_cast<int>(candidates.size()));
  std::vector<Trial> trials;
  for (const ScreenedCandidate& entry : screened) {
    if (static_cast<int>(trials.size()) >= options.refitted || entry.score.rank == 0) break;
    Trial trial;
    trial.model = Extend(model, {entry.candidate.spec}, options.joint);
    if (!IsUsable(trial.model.estimate.status)) continue;
    trial.step.candidate = entry.candidate;
    trial.step.parameters = NumParameters(trial.model, entry.candidate.spec);
    if (trial.step.parameters == 0) continue;
    trial.step.reduction = model.estimate.chi2 - trial.model.estimate.chi2;
    trial.step.penalised = trial.step.reduction - Penalty(model, trial.step.parameters, entry.candidate.settings);
    trial.step.corrected_p = CorrectedP(trial.step.reduction, trial.step.parameters, trial.model.estimate, tests);
    trials.push_back(std::move(trial));
  }
  if (trials.empty()) return false;
  double best = -1e300;
  for (const Trial& trial : trials) best = std::max(best, trial.step.penalised);
  const auto simpler = [&](const Trial& a, const Trial& b) {
    const bool a_tied = a.step.penalised >= best - options.tie, b_tied = b.step.penalised >= best - options.tie;
    if (a_tied != b_tied) return a_tied;
    if (a.step.parameters != b.step.parameters) return a.step.parameters < b.step.parameters;
    if (a.step.candidate.catalogue != b.step.candidate.catalogue) {
      return a.step.candidate.catalogue < b.step.candidate.catalogue;
    }
    return a.step.penalised > b.step.penalised;
  };
  *picked = *std::min_element(trials.begin(), trials.end(), simpler);
  return picked->step.corrected_p < options.significance && picked->step.penalised > 0.0;
}

std::vector<EffectSpec> SpecsOf(const std::vector<ChosenStep>& steps) {
  std::vector<EffectSpec> specs;
  for (const ChosenStep& step : steps) specs.push_back(step.candidate.spec);
  return specs;
}

// Drops each step once and lets the screening name a better one.
bool SwapOne(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates, const SelectionOptions& options,
             std::vector<ChosenStep>* steps, DiagnosedModel* model) {
  const double total = PenalisedTotal(baseline, *model, *steps);
  for (size_t i = 0; i < steps->size(); ++i) {
    std::vector<ChosenStep> others = *steps;
    others.erase(others.begin() + static_cast<long>(i));
    const DiagnosedModel without = Extend(baseline, SpecsOf(others), options.joint);
    if (!IsUsable(without.estimate.status)) continue;
    if (PenalisedTotal(baseline, without, others) > total) {  // no longer needed
      *steps = others;
      *model = without;
      return true;
    }
    Trial trial;
    if (!PickStep(without, candidates, options, &trial)) continue;
    if (trial.step.candidate.spec.Path() == (*steps)[i].candidate.spec.Path()) continue;
    others.insert(others.begin() + static_cast<long>(i), trial.step);
    if (PenalisedTotal(baseline, trial.model, others) <= total + 1.0) continue;
    *steps = others;
    *model = trial.model;
    return true;
  }
  return false;
}

}  // namespace

std::vector<ScreenedCandidate> Screen(const DiagnosedModel& model, const std::vector<Candidate>& candidates,
                                      int most_tests) {
  const ProjectedResidual residual(LinearizeEstimate(*model.problem, model.estimate.parameters));
  const double left = model.estimate.dof > 0 ? std::max(1.0, model.estimate.chi2 / model.estimate.dof) : 1.0;
  const int tests = std::min<int>(most_tests, static_cast<int>(candidates.size()));
  std::vector<ScreenedCandidate> screened;
  for (const Candidate& candidate : candidates) {
    ScreenedCandidate entry{candidate, {}, 1.0};
    entry.score =
        residual.Test(CandidateColumns(*model.problem, model.estimate.parameters, candidate.spec), candidate.settings);
    const double after =
        (model.estimate.chi2 - entry.score.reduction) / std::max(1, model.estimate.dof - entry.score.rank);
    const double yardstick = std::min(left, std::max(1.0, after));
    if (entry.score.rank > 0) {
      entry.corrected_p = std::min(1.0, tests * ChiSquareSurvival(entry.score.reduction / yardstick, entry.score.rank));
    }
    screened.push_back(std::move(entry));
  }
  std::stable_sort(screened.begin(), screened.end(), [](const auto& a, const auto& b) {
    if ((a.score.rank > 0) != (b.score.rank > 0)) return a.score.rank > 0;
    return a.score.penalised > b.score.penalised;
  });
  return screened;
}

DiagnosedModel Extend(const DiagnosedModel& model, const std::vector<EffectSpec>& specs, const JointOptions& options) {
  DiagnosedModel extended;
  extended.problem = std::make_shared<CalibrationProblem>(*model.problem);
  extended.problem->parameters.CopyByName(model.estimate.parameters);
  for (const EffectSpec& spec : specs) {
    extended.problem = std::make_shared<CalibrationProblem>(extended.problem->WithEffect(spec));
  }
  extended.estimate = EstimateFrom(*extended.problem, extended.problem->parameters, options);
  return extended;
}

double PenalisedTotal(const DiagnosedModel& baseline, const DiagnosedModel& model,
                      const std::vector<ChosenStep>& steps) {
  double total = baseline.estimate.chi2 - model.estimate.chi2;
  for (const ChosenStep& step : steps) total -= Penalty(baseline, step.parameters, step.candidate.settings);
  return total;
}

std::vector<ChosenStep> SelectEffects(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates,
                                      const SelectionOptions& options, DiagnosedModel* model) {
  std::vector<ChosenStep> steps;
  *model = baseline;
  Trial trial;
  while (static_cast<int>(steps.size()) < options.most_steps && PickStep(*model, candidates, options, &trial)) {
    steps.push_back(trial.step);
    *model = trial.model;
    if (options.progress) {
      options.progress("step " + std::to_string(steps.size()) + ": " + trial.step.candidate.spec.Path());
    }
    if (steps.size() > 1) {
      for (int pass = 0; pass < 2 && SwapOne(baseline, candidates, options, &steps, model); ++pass) {
      }
    }
  }
  return steps;
}

}  // namespace sagitta
