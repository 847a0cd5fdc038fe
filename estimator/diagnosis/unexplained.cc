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
constexpr double kOwnCause = 0.5;    // of a step's gain that is left beside everything of a decoy's kind

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

// Steps chosen beside what `left[0]` believes, and what is left after each.
struct Beside {
  std::vector<ChosenStep> steps;
  std::vector<Eigen::MatrixXd> columns;  // of each step
  std::vector<ProjectedResidual> left;   // one more than steps: before the first
};

Beside SelectBeside(const Bench& bench, const ProjectedResidual& residual, const SelectionOptions& options) {
  Beside beside{{}, {}, {residual}};
  while (static_cast<int>(beside.steps.size()) < options.most_steps / 2) {
    std::optional<PickedBeside> picked = PickBeside(bench, beside.left.back(), options);
    if (!picked) break;
    beside.steps.push_back(std::move(picked->step));
    beside.left.push_back(beside.left.back().With(picked->columns));
    beside.columns.push_back(std::move(picked->columns));
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

// The first steps hold, and what they leave has no name.
struct Partial {
  std::vector<ChosenStep> held;
  DiagnosedModel model;
  Decoy decoy;
  double gain = 0.0;  // penalised, of the steps and the decoy together
};

std::optional<Partial> WithDecoy(const DiagnosedModel& baseline, const SelectionOptions& options,
                                 const std::vector<ChosenStep>& steps, int kept) {
  Partial partial{{steps.begin(), steps.begin() + kept}, baseline, {}, 0.0};
  if (kept > 0) partial.model = Extend(baseline, CandidatesOf(partial.held), options.joint);
  if (!IsUsable(partial.model.estimate.status)) return std::nullopt;
  partial.decoy = DecoyBench(partial.model).Best();
  partial.gain = PenalisedTotal(baseline, partial.model, partial.held) + partial.decoy.penalised;
  return partial;
}

// Whether the decoy's contribution is something that the effect can do too: then it leads by its fewer parameters only,
// and is no sign of another cause.
bool Contains(const Partial& without, const ChosenStep& step) {
  const CalibrationProblem& problem = *without.model.problem;
  const ParameterSet& parameters = without.model.estimate.parameters;
  const Eigen::MatrixXd own = ColumnsOf(problem, parameters, {step.candidate.spec}).columns;
  if (own.cols() <= without.decoy.columns.cols()) return false;
  const ProjectedResidual residual(LinearizeEstimate(problem, parameters));
  const Eigen::VectorXd fitted = residual.Reproduce(without.decoy.columns, residual.residual());
  return (fitted - residual.Reproduce(own, fitted)).squaredNorm() < (1.0 - kContained) * fitted.squaredNorm();
}

// Of the steps that a decoy competes with, those whose gain vanishes beside everything of its kind are replaced: they
// only imitated the same. The others are causes of their own.
struct Replacement {
  std::vector<bool> is_replaced;
  size_t replaced = 0;
  double gain = 0.0;  // penalised, of all that holds and the decoy

  bool Beats(double total) const { return replaced > 0 && gain > total + Margin(replaced); }
};

// `columns` of those steps, the last ones; `gain` of the steps before and the decoy.
Replacement Replace(const ProjectedResidual& residual, const Eigen::MatrixXd& kind,
                    const std::vector<ChosenStep>& steps, const std::vector<Eigen::MatrixXd>& columns, double gain) {
  Replacement replacement;
  replacement.gain = gain;
  ProjectedResidual left = residual.With(kind);
  const size_t before = steps.size() - columns.size();
  for (size_t i = 0; i < columns.size(); ++i) {
    const ChosenStep& step = steps[before + i];
    const double own = left.Test(columns[i], step.candidate.settings).penalised;
    replacement.is_replaced.push_back(own < kOwnCause * step.penalised);
    if (replacement.is_replaced.back()) {
      ++replacement.replaced;
    } else {
      replacement.gain += std::min(own, step.penalised);
      left = left.With(columns[i]);
    }
  }
  return replacement;
}

Replacement Replace(const Partial& partial, const std::vector<ChosenStep>& steps) {
  const DecoyBench bench(partial.model);
  std::vector<Eigen::MatrixXd> columns;
  for (size_t i = partial.held.size(); i < steps.size(); ++i) {
    const ParameterSet& parameters = partial.model.estimate.parameters;
    columns.push_back(ColumnsOf(*partial.model.problem, parameters, {steps[i].candidate.spec}).columns);
  }
  return Replace(bench.residual(), bench.ColumnsOfKind(partial.decoy), steps, columns, partial.gain);
}

// The least number of steps beside which a decoy does better than all of them (`total`); none where they hold. Further
// steps that gain beside a decoy of another kind hold too: a cause with a name, and one without.
std::optional<Partial> BeatenByDecoy(const DiagnosedModel& baseline, const SelectionOptions& options,
                                     const std::vector<ChosenStep>& steps, double total) {
  const int count = static_cast<int>(steps.size());
  std::optional<Partial> beaten = FirstFound<Partial>(count, options.num_threads, [&](int kept) {
    std::optional<Partial> partial = WithDecoy(baseline, options, steps, kept);
    if (!partial || !Replace(*partial, steps).Beats(total)) return std::optional<Partial>();
    if (kept + 1 == count && Contains(*partial, steps.back())) partial.reset();
    return partial;
  });
  while (beaten && static_cast<int>(beaten->held.size()) < count) {
    if (Replace(*beaten, steps).is_replaced[0]) break;
    std::optional<Partial> more = WithDecoy(baseline, options, steps, static_cast<int>(beaten->held.size()) + 1);
    if (!more || more->gain <= beaten->gain + kUnknownMargin) break;
    beaten = std::move(more);
  }
  return beaten;
}

// The same among steps to first order: how many hold, and the decoy beside them.
struct Cut {
  size_t kept;
  Decoy decoy;
  double gain;
  Replacement replacement;
};

Cut CutAt(const Bench& bench, const Beside& beside, size_t kept) {
  const ProjectedResidual& residual = beside.left[kept];
  Decoy decoy = bench.decoys.Best(residual);
  const double gain = Sum(beside.steps, kept) + decoy.penalised;
  const std::vector<Eigen::MatrixXd> columns(beside.columns.begin() + static_cast<long>(kept), beside.columns.end());
  Replacement replacement = Replace(residual, bench.decoys.ColumnsOfKind(decoy), beside.steps, columns, gain);
  return {kept, std::move(decoy), gain, std::move(replacement)};
}

std::optional<Cut> CutByDecoy(const Bench& bench, const Beside& beside) {
  const size_t count = beside.steps.size();
  const double total = Sum(beside.steps, count);
  std::optional<Cut> cut;
  for (size_t kept = 0; kept < count && !cut; ++kept) {
    Cut here = CutAt(bench, beside, kept);
    if (here.replacement.Beats(total)) cut = std::move(here);
  }
  while (cut && cut->kept < count && !cut->replacement.is_replaced[0]) {
    Cut more = CutAt(bench, beside, cut->kept + 1);
    if (more.gain <= cut->gain + kUnknownMargin) break;
    cut = std::move(more);
  }
  return cut;
}

// What has a name beside a decoy: the same question again beside everything of its kind, until the steps hold.
std::vector<ChosenStep> StepsBeside(const Bench& bench, const Decoy& first, const SelectionOptions& options) {
  std::vector<ChosenStep> held;
  ProjectedResidual residual = bench.decoys.residual().With(bench.decoys.ColumnsOfKind(first));
  for (size_t decoys = 1;; ++decoys) {
    const Beside beside = SelectBeside(bench, residual, options);
    std::optional<Cut> cut;
    if (decoys < kMostDecoys) cut = CutByDecoy(bench, beside);
    const size_t kept = cut ? cut->kept : beside.steps.size();
    held.insert(held.end(), beside.steps.begin(), beside.steps.begin() + static_cast<long>(kept));
    if (!cut) return held;
    residual = beside.left[kept].With(bench.decoys.ColumnsOfKind(cut->decoy));
  }
}

}  // namespace

Unexplained KeepWhatHolds(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates,
                          const SelectionOptions& options, std::vector<ChosenStep>* steps, DiagnosedModel* model) {
  Unexplained rest;
  const double total = PenalisedTotal(baseline, *model, *steps) + MarginalBonus(baseline, *steps, options);
  const std::optional<Partial> beaten = BeatenByDecoy(baseline, options, *steps, total);
  if (!beaten) return rest;
  rest.found = true;
  rest.decoy = beaten->decoy;
  *steps = beaten->held;
  *model = beaten->model;
  const std::vector<ChosenStep> further = StepsBeside(Bench(*model, candidates), rest.decoy, options);
  if (!further.empty()) {
    DiagnosedModel extended = Extend(*model, CandidatesOf(further), options.joint);
    if (IsUsable(extended.estimate.status)) {
      *model = std::move(extended);
      steps->insert(steps->end(), further.begin(), further.end());
    }
  }
  if (!steps->empty()) rest.decoy = DecoyBench(*model).Best();
  return rest;
}

}  // namespace sagitta
