#include "estimator/diagnosis/unexplained.h"

#include <algorithm>

#include "estimator/distributions.h"

namespace sagitta {
namespace {

constexpr size_t kMostDecoys = 4;
constexpr int kManyParameters = 3;

// The best candidate beside what `residual` believes, by the rule of FORMATS
// section 6 on the linear reductions; false when none is significant.
bool PickBeside(const DiagnosedModel& model, const ProjectedResidual& residual,
                const std::vector<Candidate>& candidates, const SelectionOptions& options, ChosenStep* picked) {
  const std::vector<EffectSpec> specs = SpecsOf(candidates);
  std::vector<CandidateColumns> columns = ColumnsOf(*model.problem, model.estimate.parameters, specs);
  const double chi2 = residual.residual().squaredNorm();
  const int tests = std::min<int>(options.most_tests, static_cast<int>(candidates.size()));
  std::vector<ChosenStep> entries;
  double best = 0.0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    ChosenStep entry;
    entry.candidate = candidates[i];
    entry.candidate.vague = DropUninformed(residual, &columns[i]);
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

// Steps chosen beside decoys whose kinds are believed, and the models after each.
struct Beside {
  std::vector<ChosenStep> steps;
  std::vector<DiagnosedModel> models;  // one more than steps: the baseline first
};

Beside SelectBeside(const DiagnosedModel& baseline, const std::vector<Decoy>& decoys,
                    const std::vector<Candidate>& candidates, const SelectionOptions& options) {
  Beside beside{{}, {baseline}};
  while (static_cast<int>(beside.steps.size()) < options.most_steps / 2) {
    const DiagnosedModel& model = beside.models.back();
    ProjectedResidual residual(LinearizeEstimate(*model.problem, model.estimate.parameters));
    for (const Decoy& decoy : decoys) residual = residual.With(ColumnsOfKind(model, decoy));
    ChosenStep step;
    if (!PickBeside(model, residual, candidates, options, &step)) break;
    DiagnosedModel next = Extend(model, {step.candidate}, options.joint);
    if (!IsUsable(next.estimate.status)) break;
    beside.steps.push_back(step);
    beside.models.push_back(std::move(next));
  }
  return beside;
}

double Sum(const std::vector<ChosenStep>& steps, size_t count) {
  double sum = 0.0;
  for (size_t i = 0; i < count; ++i) sum += steps[i].penalised;
  return sum;
}

// One cause instead of several is the simpler answer; one instead of one is a tie.
double Margin(size_t steps_replaced) { return steps_replaced > 1 ? 0.0 : kUnknownMargin; }

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
  std::vector<Decoy> decoys;
  DiagnosedModel partial = baseline;
  std::vector<ChosenStep> held;
  for (size_t kept = 0; kept < steps->size() && decoys.empty(); ++kept) {
    if (kept > 0) {
      held.push_back((*steps)[kept - 1]);
      partial = Extend(partial, {held.back().candidate}, options.joint);
      if (!IsUsable(partial.estimate.status)) return rest;
    }
    const Decoy decoy = BestDecoy(partial);
    const double gain = PenalisedTotal(baseline, partial, held) + decoy.penalised;
    if (gain > total + Margin(steps->size() - kept)) decoys.push_back(decoy);
  }
  if (decoys.empty()) return rest;
  rest.found = true;
  rest.decoy = decoys[0];
  // The steps before it hold. Beside what has no name the same question again,
  // until the further steps hold.
  for (;;) {
    Beside beside = SelectBeside(partial, decoys, candidates, options);
    const double sum = Sum(beside.steps, beside.steps.size());
    bool holds = true;
    for (size_t kept = 0; kept < beside.steps.size() && holds && decoys.size() < kMostDecoys; ++kept) {
      const Decoy decoy = BestDecoy(beside.models[kept], decoys);
      holds = Sum(beside.steps, kept) + decoy.penalised <= sum + Margin(beside.steps.size() - kept);
      if (!holds) decoys.push_back(decoy);
    }
    if (!holds) continue;
    *model = std::move(beside.models.back());
    *steps = held;
    steps->insert(steps->end(), beside.steps.begin(), beside.steps.end());
    if (!steps->empty()) rest.decoy = BestDecoy(*model);
    return rest;
  }
}

}  // namespace sagitta
