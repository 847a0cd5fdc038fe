#include "estimator/diagnosis/unexplained.h"

#include <algorithm>

#include "estimator/distributions.h"

namespace sagitta {
namespace {

constexpr int kMostDecoys = 4;
constexpr int kManyParameters = 3;

// The best candidate beside what `residual` believes, by the rule of FORMATS
// section 6 on the linear reductions; false when none is significant.
bool PickBeside(const DiagnosedModel& model, const ProjectedResidual& residual,
                const std::vector<Candidate>& candidates, const SelectionOptions& options, ChosenStep* picked) {
  std::vector<EffectSpec> specs;
  for (const Candidate& candidate : candidates) specs.push_back(candidate.spec);
  std::vector<CandidateColumns> columns = ColumnsOf(*model.problem, model.estimate.parameters, specs);
  const double chi2 = residual.residual().squaredNorm();
  const int tests = std::min<int>(options.most_tests, static_cast<int>(candidates.size()));
  std::vector<ChosenStep> entries;
  double best = 0.0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    ChosenStep entry;
    entry.candidate = candidates[i];
    entry.candidate.held = DropUninformed(residual, &columns[i]);
    const Score score = residual.Test(columns[i].columns, candidates[i].settings);
    if (score.rank == 0 || score.penalised <= 0.0) continue;
    const double left = std::max(1.0, (chi2 - score.reduction) / std::max(1, model.estimate.dof));
    entry.parameters = score.rank;
    entry.reduction = score.reduction;
    entry.penalised = score.reduction / left - (score.reduction - score.penalised);
    entry.corrected_p = std::min(1.0, tests * ChiSquareSurvival(score.reduction / left, score.rank));
    best = std::max(best, entry.penalised);
    entries.push_back(entry);
  }
  const ChosenStep* chosen = nullptr;
  for (const ChosenStep& entry : entries) {
    if (entry.penalised < best - options.tie || entry.corrected_p >= options.significance) continue;
    if (chosen == nullptr || entry.parameters < chosen->parameters) chosen = &entry;
  }
  if (chosen == nullptr) return false;
  *picked = *chosen;
  return true;
}

// Refits with one more step; false (and nothing changes) where that fails.
bool Add(const ChosenStep& step, const SelectionOptions& options, std::vector<ChosenStep>* steps,
         DiagnosedModel* model) {
  DiagnosedModel next = Extend(*model, {step.candidate}, options.joint);
  if (!IsUsable(next.estimate.status)) return false;
  steps->push_back(step);
  *model = std::move(next);
  return true;
}

// Forward steps beside the decoys' kinds, whose columns are believed.
void SelectBeside(const std::vector<Decoy>& decoys, const std::vector<Candidate>& candidates,
                  const SelectionOptions& options, std::vector<ChosenStep>* steps, DiagnosedModel* model) {
  while (static_cast<int>(steps->size()) < options.most_steps) {
    ProjectedResidual residual(LinearizeEstimate(*model->problem, model->estimate.parameters));
    for (const Decoy& decoy : decoys) residual = residual.With(ColumnsOfKind(*model, decoy));
    ChosenStep step;
    if (!PickBeside(*model, residual, candidates, options, &step) || !Add(step, options, steps, model)) return;
  }
}

// Effects of many parameters lose much by p ln(n), decoys of many columns by
// their marginal likelihood only: what a step gains when it is scored like them.
double MarginalBonus(const DiagnosedModel& baseline, const std::vector<ChosenStep>& steps,
                     const SelectionOptions& options) {
  double bonus = 0.0;
  for (size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].parameters < kManyParameters || steps[i].candidate.spec.effect == "gravity_compensator") continue;
    std::vector<ChosenStep> others = steps;
    others.erase(others.begin() + static_cast<long>(i));
    const DiagnosedModel without = Extend(baseline, CandidatesOf(others), options.joint);
    if (!IsUsable(without.estimate.status)) continue;
    const ProjectedResidual residual(LinearizeEstimate(*without.problem, without.estimate.parameters));
    CandidateColumns own = ColumnsOf(*without.problem, without.estimate.parameters, {steps[i].candidate.spec})[0];
    DropUninformed(residual, &own);
    const Eigen::MatrixXd typical = own.columns * own.typical.asDiagonal();
    const double settings = 2.0 * std::log(steps[i].candidate.settings);
    const double penalised = residual.Test(own.columns, steps[i].candidate.settings).penalised;
    bonus += std::max(0.0, residual.MarginalGain(typical) - settings - penalised);
  }
  return bonus;
}

}  // namespace

Unexplained KeepWhatHolds(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates,
                          const SelectionOptions& options, std::vector<ChosenStep>* steps, DiagnosedModel* model) {
  Unexplained rest;
  const double total = PenalisedTotal(baseline, *model, *steps) + MarginalBonus(baseline, *steps, options);
  DiagnosedModel partial = baseline;
  std::vector<ChosenStep> held;
  for (size_t kept = 0; kept < steps->size(); ++kept) {
    if (kept > 0 && !Add((*steps)[kept - 1], options, &held, &partial)) return rest;
    const Decoy decoy = BestDecoy(partial);
    // One cause instead of several is the simpler answer; one instead of one is a tie.
    const double margin = steps->size() - kept > 1 ? 0.0 : kUnknownMargin;
    if (PenalisedTotal(baseline, partial, held) + decoy.penalised <= total + margin) continue;
    std::vector<Decoy> decoys = {decoy};
    const size_t before = held.size();
    SelectBeside(decoys, candidates, options, &held, &partial);
    // Further causes without a name must not bring steps back either.
    while (held.size() > before && decoys.size() < kMostDecoys) {
      decoys.push_back(BestDecoy(partial, decoys));
      if (decoys.back().penalised < kUnknownMargin) break;
      DiagnosedModel again = baseline;
      std::vector<ChosenStep> kept_again;
      for (size_t i = 0; i < before; ++i) Add(held[i], options, &kept_again, &again);
      SelectBeside(decoys, candidates, options, &kept_again, &again);
      const bool settled = kept_again.size() == held.size();
      held = std::move(kept_again);
      partial = std::move(again);
      if (settled) break;
    }
    rest.found = true;
    rest.decoy = held.empty() ? decoy : BestDecoy(partial);
    *steps = std::move(held);
    *model = std::move(partial);
    return rest;
  }
  return rest;
}

}  // namespace sagitta
