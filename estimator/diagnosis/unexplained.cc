#include "estimator/diagnosis/unexplained.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "estimator/diagnosis/candidate_bench.h"
#include "estimator/least_squares/parallel.h"

namespace sagitta {
namespace {

constexpr size_t kMostDecoys = 4;
constexpr int kManyParameters = 3;
constexpr double kContained = 0.95;  // share of the decoy's contribution
constexpr double kOwnCause = 0.5;    // of a step's gain that is left beside everything of a decoy's kind

// What candidates and decoys do at one model, to first order.
struct Bench {
  Bench(const DiagnosedModel& model, const std::vector<Candidate>& catalogue)
      : decoys(model), candidates(*model.problem, model.estimate.parameters, catalogue), dof(model.estimate.dof) {}

  // Left where more than the model is believed.
  int DofBeside(const ProjectedResidual& residual) const {
    return dof - static_cast<int>(residual.basis().cols() - decoys.residual().basis().cols());
  }

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
                                       const SelectionOptions& options, const std::set<std::string>& taken) {
  const double chi2 = residual.residual().squaredNorm();
  const std::vector<Candidate>& candidates = bench.candidates.candidates();
  const int tests = static_cast<int>(candidates.size());
  const Screening screening(bench.candidates, residual, true);
  const int dof = bench.DofBeside(residual);
  std::vector<ChosenStep> steps;
  std::map<std::string, CandidateScore> scores;  // by path
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (taken.count(candidates[i].spec.Path()) > 0) continue;  // an effect is one step
    const CandidateScore scored = screening.Of(static_cast<int>(i));
    const Score& score = scored.score;
    if (score.rank == 0 || score.penalised <= 0.0) continue;
    const double left = std::max(1.0, (chi2 - score.reduction) / std::max(1, dof - score.rank));
    ChosenStep step;
    step.candidate = candidates[i];
    step.candidate.vague = scored.vague;
    step.candidate.oversized = scored.oversized;
    step.parameters = score.rank;
    step.reduction = score.reduction / left;
    step.penalised = step.reduction - (score.reduction - score.penalised);
    step.corrected_p = CorrectedP(score.reduction, score.rank, left, dof - score.rank, tests);
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

Beside SelectBeside(const Bench& bench, const ProjectedResidual& residual, const SelectionOptions& options,
                    std::set<std::string> taken) {
  Beside beside{{}, {}, {residual}};
  while (static_cast<int>(beside.steps.size()) < options.most_steps / 2) {
    std::optional<PickedBeside> picked = PickBeside(bench, beside.left.back(), options, taken);
    if (!picked) break;
    taken.insert(picked->step.candidate.spec.Path());
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

// Of the steps that a decoy competes with, those whose gain vanishes beside everything of its kind are replaced: they
// only imitated the same. The others are causes of their own.
struct Replacement {
  std::vector<bool> is_replaced;
  size_t replaced = 0;
  double gain = 0.0;  // penalised, of the others
};

Replacement Replace(const ProjectedResidual& residual, const Eigen::MatrixXd& kind,
                    const std::vector<ChosenStep>& competing, const std::vector<Eigen::MatrixXd>& columns) {
  Replacement replacement;
  ProjectedResidual left = residual.With(kind);
  const double per_parameter = std::log(static_cast<double>(residual.residual().size()));
  for (size_t i = 0; i < competing.size(); ++i) {
    const int of_shape = std::max(0, competing[i].parameters - static_cast<int>(columns[i].cols()));  // a compensator's
    const double own = left.Test(columns[i], competing[i].candidate.settings).penalised - of_shape * per_parameter;
    replacement.is_replaced.push_back(own < kOwnCause * competing[i].penalised);
    if (replacement.is_replaced.back()) {
      ++replacement.replaced;
    } else {
      replacement.gain += std::min(own, competing[i].penalised);
      left = left.With(columns[i]);
    }
  }
  return replacement;
}

// The first steps hold, and a decoy does what the others only imitate.
struct Cut {
  size_t kept = 0;
  Decoy decoy;
  double gain = 0.0;  // penalised, of the steps that are kept and the decoy
  Replacement others;

  // Whether that is better than all steps.
  bool Beats(double total) const { return others.replaced > 0 && gain + others.gain > total + Margin(others.replaced); }
  // Whether the next step is a cause of its own, and gains where it is kept too.
  bool GrowsTo(const Cut& next) const { return next.gain > gain + kUnknownMargin; }
  bool MayGrow() const { return !others.is_replaced.empty() && !others.is_replaced[0]; }
};

Cut CutAt(const DecoyBench& bench, const ProjectedResidual& residual, double gain_of_kept,
          const std::vector<ChosenStep>& steps, size_t kept, const std::vector<Eigen::MatrixXd>& columns) {
  Cut cut{kept, bench.Best(residual), 0.0, {}};
  cut.gain = gain_of_kept + cut.decoy.penalised;
  const std::vector<ChosenStep> competing(steps.begin() + static_cast<long>(kept), steps.end());
  cut.others = Replace(residual, bench.ColumnsOfKind(cut.decoy), competing, columns);
  return cut;
}

// Whether the decoy's contribution is something that the effect can do too: then it leads by its fewer parameters only,
// and is no sign of another cause.
bool Contains(const ProjectedResidual& residual, const Eigen::MatrixXd& own, const Decoy& decoy) {
  if (own.cols() <= decoy.columns.cols()) return false;
  const Eigen::VectorXd fitted = residual.Reproduce(decoy.columns, residual.residual());
  return (fitted - residual.Reproduce(own, fitted)).squaredNorm() < (1.0 - kContained) * fitted.squaredNorm();
}

// A cut at the model that the kept steps make.
struct Partial {
  Cut cut;
  DiagnosedModel model;
  bool contained = false;  // the decoy, in the only step that it competes with
};

// What each step can do at a model that lacks it, to first order; a compensator in the shape that
// its refit started from.
std::vector<Eigen::MatrixXd> ColumnsAt(const DiagnosedModel& model, const std::vector<EffectSpec>& specs) {
  const CalibrationProblem& problem = *model.problem;
  const ParameterSet& parameters = model.estimate.parameters;
  const CandidateColumns all = ColumnsOf(problem, parameters, specs);
  std::vector<Eigen::MatrixXd> columns;
  for (size_t i = 0; i < specs.size(); ++i) {
    const int candidate = static_cast<int>(i);
    if (specs[i].effect != "gravity_compensator") {
      columns.push_back(all.columns.middleCols(all.first[i], all.count(candidate)));
      continue;
    }
    const Eigen::MatrixXd deviations = JointDeviationColumns(problem, parameters);
    const Eigen::VectorXd deviation = deviations.col(problem.robot.chain.FindJoint(specs[i].target));
    columns.push_back(SpringColumns(SeatOf(problem, parameters, specs[i].target, deviation), specs[i]));
  }
  return columns;
}

std::optional<Partial> CutAt(const DiagnosedModel& baseline, const SelectionOptions& options,
                             const std::vector<ChosenStep>& steps, size_t kept) {
  const std::vector<ChosenStep> held(steps.begin(), steps.begin() + static_cast<long>(kept));
  Partial partial{{}, kept > 0 ? Extend(baseline, CandidatesOf(held), options.joint) : baseline, false};
  const DiagnosedModel& model = partial.model;
  if (!IsUsable(model.estimate.status)) return std::nullopt;
  std::vector<EffectSpec> specs;
  for (size_t i = kept; i < steps.size(); ++i) specs.push_back(steps[i].candidate.spec);
  const std::vector<Eigen::MatrixXd> columns = ColumnsAt(model, specs);
  const DecoyBench bench(model);
  partial.cut = CutAt(bench, bench.residual(), PenalisedTotal(baseline, model, held), steps, kept, columns);
  partial.contained = kept + 1 == steps.size() && Contains(bench.residual(), columns.back(), partial.cut.decoy);
  return partial;
}

// The least number of steps beside which a decoy does better than all of them (`total`); none where they hold. Further
// steps that gain beside it and are causes of their own hold too: a cause with a name, and one without.
std::optional<Partial> BeatenByDecoy(const DiagnosedModel& baseline, const SelectionOptions& options,
                                     const std::vector<ChosenStep>& steps, double total) {
  std::optional<Partial> beaten =
      FirstFound<Partial>(static_cast<int>(steps.size()), options.num_threads, [&](int kept) {
        std::optional<Partial> partial = CutAt(baseline, options, steps, kept);
        if (partial && (!partial->cut.Beats(total) || partial->contained)) partial.reset();
        return partial;
      });
  while (beaten && beaten->cut.MayGrow()) {
    std::optional<Partial> more = CutAt(baseline, options, steps, beaten->cut.kept + 1);
    if (!more || !beaten->cut.GrowsTo(more->cut)) break;
    beaten = std::move(more);
  }
  return beaten;
}

// The same among steps to first order.
std::optional<Cut> CutByDecoy(const Bench& bench, const Beside& beside) {
  const size_t count = beside.steps.size();
  const double total = Sum(beside.steps, count);
  const auto cut_at = [&](size_t kept) {
    const std::vector<Eigen::MatrixXd> columns(beside.columns.begin() + static_cast<long>(kept), beside.columns.end());
    return CutAt(bench.decoys, beside.left[kept], Sum(beside.steps, kept), beside.steps, kept, columns);
  };
  std::optional<Cut> cut;
  for (size_t kept = 0; kept < count && !cut; ++kept) {
    Cut here = cut_at(kept);
    if (here.Beats(total)) cut = std::move(here);
  }
  while (cut && cut->MayGrow()) {
    Cut more = cut_at(cut->kept + 1);
    if (!cut->GrowsTo(more)) break;
    cut = std::move(more);
  }
  return cut;
}

// What has a name beside a decoy: the same question again beside everything of its kind, until the steps hold.
std::vector<ChosenStep> StepsBeside(const Bench& bench, const Decoy& first, const SelectionOptions& options) {
  std::vector<ChosenStep> held;
  std::set<std::string> taken;
  ProjectedResidual residual = bench.decoys.residual().With(bench.decoys.ColumnsOfKind(first));
  for (size_t decoys = 1;; ++decoys) {
    const Beside beside = SelectBeside(bench, residual, options, taken);
    std::optional<Cut> cut;
    if (decoys < kMostDecoys) cut = CutByDecoy(bench, beside);
    const size_t kept = cut ? cut->kept : beside.steps.size();
    held.insert(held.end(), beside.steps.begin(), beside.steps.begin() + static_cast<long>(kept));
    if (!cut) return held;
    for (const ChosenStep& step : held) taken.insert(step.candidate.spec.Path());
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
  rest.decoy = beaten->cut.decoy;
  steps->resize(beaten->cut.kept);
  *model = beaten->model;
  const std::vector<ChosenStep> further = StepsBeside(Bench(*model, candidates), rest.decoy, options);
  if (!further.empty()) {
    DiagnosedModel extended = Extend(*model, CandidatesOf(further), options.joint);
    if (IsUsable(extended.estimate.status)) {
      *model = std::move(extended);
      steps->insert(steps->end(), further.begin(), further.end());
    }
  }
  if (!steps->empty()) rest.decoy = DecoyBench(*model).BestInScatter();
  return rest;
}

}  // namespace sagitta
