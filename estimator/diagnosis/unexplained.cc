#include "estimator/diagnosis/unexplained.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "estimator/diagnosis/candidate_bench.h"
#include "estimator/distributions.h"
#include "estimator/parallel.h"

namespace sagitta {
namespace {

constexpr size_t kMostDecoys = 4;
constexpr int kManyParameters = 3;
constexpr double kContained = 0.95;  // share of the decoy's contribution

// What candidates and decoys do at one model, to first order.
struct Bench {
  Bench(const DiagnosedModel& model, const std::vector<Candidate>& catalogue)
      : decoys(model),
        candidates(*model.problem, model.estimate.parameters, catalogue),
        dof(std::max(1, model.estimate.dof)) {}

  DecoyBench decoys;
  CandidateBench candidates;
  int dof;
};

// The best candidate beside what `residual` believes, by the rule on the linear reductions in units of the scatter that
// is left, and its columns; none when nothing is significant. A compensator's shape is not linear: it takes no part.
struct PickedBeside {
  ChosenStep step;
  Eigen::MatrixXd columns;
};

std::optional<PickedBeside> PickBeside(const Bench& bench, const ProjectedResidual& residual,
                                       const SelectionOptions& options) {
  const double chi2 = residual.residual().squaredNorm();
  const std::vector<Candidate>& candidates = bench.candidates.candidates();
  const int tests = static_cast<int>(candidates.size());
  const Screening screening(bench.candidates, residual, true);
  std::vector<ChosenStep> steps;
  std::map<std::string, CandidateScore> scores;  // by path
  for (size_t i = 0; i < candidates.size(); ++i) {
    const CandidateScore scored = screening.Of(static_cast<int>(i));
    const Score& score = scored.score;
    if (score.rank == 0 || score.penalised <= 0.0) continue;
    const double left = std::max(1.0, (chi2 - score.reduction) / bench.dof);
    ChosenStep step;
    step.candidate = candidates[i];
    step.candidate.vague = scored.vague;
    step.parameters = score.rank;
    step.reduction = score.reduction / left;
    step.penalised = step.reduction - (score.reduction - score.penalised);
    step.corrected_p = std::min(1.0, tests * ChiSquareSurvival(step.reduction, score.rank));
    if (step.corrected_p >= options.significance) continue;
    scores[step.candidate.spec.Path()] = scored;
    steps.push_back(std::move(step));
  }
  if (steps.empty()) return std::nullopt;
  PickedBeside picked;
  picked.step = PickByRule(steps, options.tie);
  const CandidateScore& own = scores.at(picked.step.candidate.spec.Path());
  picked.step.reduction = own.score.reduction;
  picked.columns = bench.candidates.columns().columns(Eigen::all, own.informed);
  return picked;
}

// Steps chosen beside decoys whose kinds are believed, and what is left after each.
struct Beside {
  std::vector<ChosenStep> steps;
  std::vector<ProjectedResidual> left;  // one more than steps: before the first
};

Beside SelectBeside(const Bench& bench, const std::vector<Decoy>& decoys, const SelectionOptions& options) {
  Beside beside{{}, {bench.decoys.residual()}};
  for (const Decoy& decoy : decoys) beside.left[0] = beside.left[0].With(bench.decoys.ColumnsOfKind(decoy));
  while (static_cast<int>(beside.steps.size()) < options.most_steps / 2) {
    const std::optional<PickedBeside> picked = PickBeside(bench, beside.left.back(), options);
    if (!picked) break;
    beside.steps.push_back(picked->step);
    beside.left.push_back(beside.left.back().With(picked->columns));
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

// Whether the decoy's contribution is something that the effect can do too: then it leads by its fewer parameters only,
// and is no sign of another cause.
bool Contains(const DiagnosedModel& without, const DecoyBench& bench, const ChosenStep& step, const Decoy& decoy) {
  const ProjectedResidual& residual = bench.residual();
  const Eigen::VectorXd fitted = residual.Reproduce(decoy.columns, residual.residual());
  const Eigen::MatrixXd own = ColumnsOf(*without.problem, without.estimate.parameters, {step.candidate.spec}).columns;
  if (own.cols() <= decoy.columns.cols()) return false;
  return (fitted - residual.Reproduce(own, fitted)).squaredNorm() < (1.0 - kContained) * fitted.squaredNorm();
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
    const CandidateColumns own = ColumnsOf(*without.problem, without.estimate.parameters, {steps[i].candidate.spec});
    const std::vector<int> kept = InformedColumns(residual.Reduce(own.columns), own.typical);
    const Eigen::MatrixXd columns = own.columns(Eigen::all, kept);
    const Eigen::MatrixXd typical = columns * Eigen::VectorXd(own.typical(kept)).asDiagonal();
    const double settings = 2.0 * std::log(steps[i].candidate.settings);
    const double penalised = residual.Test(columns, steps[i].candidate.settings).penalised;
    bonus += std::max(0.0, residual.MarginalGain(typical) - settings - penalised);
  }
  return bonus;
}

// A decoy that does better than the steps from the (kept + 1)th on.
struct Beaten {
  Decoy decoy;
  std::vector<ChosenStep> held;  // the steps before
  DiagnosedModel partial;        // and their model
};

std::optional<Beaten> DecoyBeats(const DiagnosedModel& baseline, const SelectionOptions& options,
                                 const std::vector<ChosenStep>& steps, int kept, double total) {
  Beaten beaten{{}, {steps.begin(), steps.begin() + kept}, baseline};
  if (kept > 0) beaten.partial = Extend(baseline, CandidatesOf(beaten.held), options.joint);
  if (!IsUsable(beaten.partial.estimate.status)) return std::nullopt;
  const DecoyBench bench(beaten.partial);
  beaten.decoy = bench.Best();
  const double gain = PenalisedTotal(baseline, beaten.partial, beaten.held) + beaten.decoy.penalised;
  const size_t replaced = steps.size() - kept;
  if (gain <= total + Margin(replaced)) return std::nullopt;
  if (replaced == 1 && Contains(beaten.partial, bench, steps.back(), beaten.decoy)) return std::nullopt;
  return beaten;
}

}  // namespace

Unexplained KeepWhatHolds(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates,
                          const SelectionOptions& options, std::vector<ChosenStep>* steps, DiagnosedModel* model) {
  Unexplained rest;
  const double total = PenalisedTotal(baseline, *model, *steps) + MarginalBonus(baseline, *steps, options);
  const std::optional<Beaten> beaten =
      FirstFound<Beaten>(static_cast<int>(steps->size()), options.num_threads,
                         [&](int kept) { return DecoyBeats(baseline, options, *steps, kept, total); });
  if (!beaten) return rest;
  const DiagnosedModel& partial = beaten->partial;
  const std::vector<ChosenStep>& held = beaten->held;
  std::vector<Decoy> decoys = {beaten->decoy};
  rest.found = true;
  rest.decoy = decoys[0];
  // The steps before it hold. Beside what has no name the same question again,
  // until the further steps hold.
  const Bench bench(partial, candidates);
  std::vector<ChosenStep> further;
  for (bool holds = false; !holds;) {
    const Beside beside = SelectBeside(bench, decoys, options);
    further = beside.steps;
    const double sum = Sum(further, further.size());
    holds = true;
    for (size_t kept = 0; kept < further.size() && holds && decoys.size() < kMostDecoys; ++kept) {
      const Decoy decoy = bench.decoys.Best(beside.left[kept]);
      holds = Sum(further, kept) + decoy.penalised <= sum + Margin(further.size() - kept);
      if (!holds) decoys.push_back(decoy);
    }
  }
  *steps = held;
  *model = partial;
  if (!further.empty()) {
    DiagnosedModel extended = Extend(partial, CandidatesOf(further), options.joint);
    if (IsUsable(extended.estimate.status)) {
      *model = std::move(extended);
      steps->insert(steps->end(), further.begin(), further.end());
    }
  }
  if (!steps->empty()) rest.decoy = DecoyBench(*model).Best();
  return rest;
}

}  // namespace sagitta
