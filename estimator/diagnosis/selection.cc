#include "estimator/diagnosis/selection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/diagnosis/step_bench.h"
#include "estimator/least_squares/parallel.h"

namespace sagitta {
namespace {

constexpr double kPriorPerHoldLimit = 0.3;  // three typical sizes
constexpr size_t kSwappedAtOnce = 4;        // more steps are swapped at the end
constexpr size_t kShapesRefitted = 5;
constexpr double kTwins = 0.1;             // of chi-square: no data tell them apart
constexpr double kFirstOrderMargin = 2.0;  // of chi-square, before a refit says

double Penalty(const DiagnosedModel& baseline, int parameters, int settings) {
  return parameters * std::log(static_cast<double>(baseline.estimate.rows)) +
         2.0 * std::log(static_cast<double>(settings));
}

CalibrationProblem ExtendedProblem(const DiagnosedModel& model, const std::vector<Candidate>& added) {
  CalibrationProblem believed = *model.problem;
  believed.parameters.CopyByName(model.estimate.parameters);
  const std::vector<EffectSpec> specs = SpecsOf(added);
  CalibrationProblem problem = believed.WithEffects(specs);
  for (const Candidate& candidate : added) {
    for (const std::string& name : candidate.vague) {
      Coordinate& coordinate = problem.parameters.coordinate(problem.parameters.FindCoordinate(name));
      coordinate.prior_sigma = kPriorPerHoldLimit * TraitsOf(coordinate.quantity).hold_limit;
    }
  }
  const bool adds_spring = std::any_of(added.begin(), added.end(), [](const Candidate& candidate) {
    return candidate.spec.effect == "gravity_compensator";
  });
  if (adds_spring) BoundCompensatorShape(&problem.parameters);
  return problem;
}

// One candidate refitted, from the best of its starts; none where that fails.
std::optional<ChosenStep> TryStep(const DiagnosedModel& model, const ScreenedCandidate& entry,
                                  const SelectionOptions& options, int tests) {
  ChosenStep step;
  step.candidate = entry.candidate;
  step.parameters = entry.score.rank;
  double best = std::numeric_limits<double>::infinity();
  int dof = 0;
  for (const EffectSpec& start : entry.starts) {
    Candidate candidate = entry.candidate;
    candidate.spec = start;
    const CalibrationProblem problem = ExtendedProblem(model, {candidate});
    const bool oversized = entry.candidate.oversized;
    const QuickRefit quick =
        RefitQuickly(problem, problem.parameters, oversized ? Patience::kImpatient : Patience::kPatient);
    double chi2 = quick.chi2;
    int left = quick.dof;
    if (!quick.converged) {
      if (oversized) continue;  // on the way to nowhere; the full estimator takes minutes to say so
      const Estimate full = EstimateFrom(problem, problem.parameters, options.joint);
      if (!IsUsable(full.status)) continue;
      chi2 = full.chi2;
      left = full.dof;
    }
    if (chi2 >= best) continue;
    best = chi2;
    dof = left;
    step.candidate.spec = start;
  }
  if (!std::isfinite(best)) return std::nullopt;
  step.reduction = model.estimate.chi2 - best;
  step.penalised = step.reduction - Penalty(model, step.parameters, entry.candidate.settings);
  step.corrected_p = CorrectedP(step.reduction, step.parameters, best / std::max(1, dof), dof, tests);
  return step;
}

std::string PathOf(const Candidate& candidate) { return candidate.spec.Path(); }
std::string PathOf(const ScreenedCandidate& screened) { return screened.candidate.spec.Path(); }

// Refits the best of the screening and picks one; none when nothing is significant. Of those with absurd sizes, what
// has no optimum is added to `hopeless`.
std::optional<ChosenStep> PickStep(const DiagnosedModel& model, const std::vector<ScreenedCandidate>& screened,
                                   const SelectionOptions& options, std::vector<std::string>* hopeless = nullptr) {
  const int tests = static_cast<int>(screened.size());
  int refitted = 0;
  while (refitted < std::min(options.refitted, static_cast<int>(screened.size())) &&
         screened[refitted].score.rank > 0) {
    ++refitted;
  }
  std::vector<std::optional<ChosenStep>> trials(refitted);
  ParallelFor(refitted, options.num_threads,
              [&](int i, int) { trials[i] = TryStep(model, screened[i], options, tests); });
  for (int i = 0; i < refitted && hopeless != nullptr; ++i) {
    if (!trials[i] && screened[i].candidate.oversized) hopeless->push_back(PathOf(screened[i]));
  }
  std::vector<ChosenStep> steps;
  for (const std::optional<ChosenStep>& trial : trials) {
    if (trial && trial->corrected_p < options.significance && trial->penalised > 0.0) steps.push_back(*trial);
  }
  if (steps.empty()) return std::nullopt;
  return PickByRule(steps, options.tie);
}

// Whether nothing new has become so uncertain that the full estimator would hold it.
bool TellsAll(const QuickRefit& refit) {
  for (const int i : refit.parameters.EstimatedCoordinates()) {
    if (refit.sigmas[i] > TraitsOf(refit.parameters.coordinates()[i].quantity).hold_limit) return false;
  }
  return true;
}

// A refit of a compensator starts from its best shapes.
void TakeStarts(const std::vector<CompensatorShape>& shapes, ScreenedCandidate* entry) {
  entry->starts.clear();
  for (size_t s = 0; s < std::min(kShapesRefitted, shapes.size()); ++s) entry->starts.push_back(shapes[s].start);
  if (!shapes.empty()) entry->candidate.spec = shapes[0].start;
}

// Whether, to first order, a step is hardly needed or another candidate comes near it.
bool HasRival(const StepBench& bench, const ChosenStep& step, double tie) {
  const WithoutStep without = bench.Without(step, bench.NeutralResidual(step), bench.whole());
  const double own = without.residual.Test(without.own, step.candidate.settings).penalised - kFirstOrderMargin;
  if (own <= 0.0) return true;
  const Screening screening(bench.whole().candidates, without.residual, without.has_spring);
  const std::vector<Candidate>& candidates = bench.whole().candidates.candidates();
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (PathOf(candidates[i]) == step.candidate.spec.Path()) continue;
    const Score score = screening.Of(static_cast<int>(i)).score;
    if (score.rank > 0 && score.penalised > own - tie) return true;
  }
  return false;
}

struct StepsAndModel {
  std::vector<ChosenStep> steps;
  DiagnosedModel model;
};

// Drops one step and lets the screening name a better one; none where there is no better.
std::optional<StepsAndModel> Swapped(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates,
                                     const SelectionOptions& options, const StepsAndModel& now, int dropped) {
  const double total = PenalisedTotal(baseline, now.model, now.steps);
  const ChosenStep& step = now.steps[dropped];
  std::vector<ChosenStep> others = now.steps;
  others.erase(others.begin() + dropped);
  const DiagnosedModel without = Extend(baseline, CandidatesOf(others), options.joint);
  if (!IsUsable(without.estimate.status)) return std::nullopt;
  if (PenalisedTotal(baseline, without, others) > total) return StepsAndModel{others, without};  // no longer needed
  const std::optional<ChosenStep> better = PickStep(without, Screen(without, candidates), options);
  if (!better || better->candidate.spec.Path() == step.candidate.spec.Path()) return std::nullopt;
  others.insert(others.begin() + dropped, *better);
  if (PenalisedTotal(baseline, without, others) + better->reduction <= total + 1.0) return std::nullopt;
  DiagnosedModel swapped = Extend(without, {better->candidate}, options.joint);
  if (!IsUsable(swapped.estimate.status) || PenalisedTotal(baseline, swapped, others) <= total + 1.0) {
    return std::nullopt;
  }
  return StepsAndModel{std::move(others), std::move(swapped)};
}

bool SwapOne(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates, const SelectionOptions& options,
             StepsAndModel* now) {
  const StepBench bench(now->model, candidates);
  std::optional<StepsAndModel> better = FirstFound<StepsAndModel>(
      static_cast<int>(now->steps.size()), options.num_threads, [&](int i) -> std::optional<StepsAndModel> {
        if (!HasRival(bench, now->steps[i], options.tie)) return std::nullopt;
        return Swapped(baseline, candidates, options, *now, i);
      });
  if (better) *now = std::move(*better);
  return better.has_value();
}

template <typename Entry>
void Drop(const std::string& path, std::vector<Entry>* entries) {
  const auto is_it = [&](const Entry& entry) { return PathOf(entry) == path; };
  entries->erase(std::remove_if(entries->begin(), entries->end(), is_it), entries->end());
}

// One more step, the best that keeps what its quick refit promised; those that do not are open no longer.
std::optional<StepsAndModel> Grown(const DiagnosedModel& baseline, const SelectionOptions& options,
                                   const StepsAndModel& now, std::vector<Candidate>* open) {
  const double total = PenalisedTotal(baseline, now.model, now.steps);
  std::vector<ScreenedCandidate> screened = Screen(now.model, *open);
  const auto pick = [&] {
    std::vector<std::string> hopeless;
    std::optional<ChosenStep> picked = PickStep(now.model, screened, options, &hopeless);
    for (const std::string& path : hopeless) Drop(path, open);
    return picked;
  };
  while (const std::optional<ChosenStep> picked = pick()) {
    StepsAndModel next{now.steps, Extend(now.model, {picked->candidate}, options.joint)};
    next.steps.push_back(*picked);
    const bool fits = IsUsable(next.model.estimate.status) && PenalisedTotal(baseline, next.model, next.steps) > total;
    const bool swaps = next.steps.size() > 1 && next.steps.size() <= kSwappedAtOnce;
    for (int pass = 0; fits && swaps && pass < 2; ++pass) {
      if (!SwapOne(baseline, *open, options, &next)) break;
    }
    if (fits && PenalisedTotal(baseline, next.model, next.steps) > total) return next;
    const std::string path = picked->candidate.spec.Path();
    Drop(path, open);
    Drop(path, &screened);
  }
  return std::nullopt;
}

}  // namespace

ChosenStep PickByRule(const std::vector<ChosenStep>& steps, double tie) {
  double best = -1e300;
  for (const ChosenStep& step : steps) best = std::max(best, step.penalised);
  const auto simpler = [&](const ChosenStep& a, const ChosenStep& b) {
    const bool a_tied = a.penalised >= best - tie, b_tied = b.penalised >= best - tie;
    if (a_tied != b_tied) return a_tied;
    if (a.candidate.oversized != b.candidate.oversized) return b.candidate.oversized;
    if (a.parameters != b.parameters) return a.parameters < b.parameters;
    return a.candidate.place < b.candidate.place;
  };
  const std::string effect = std::min_element(steps.begin(), steps.end(), simpler)->candidate.spec.effect;
  const auto worth = [&](const ChosenStep& step) {
    if (step.candidate.spec.effect != effect) return -std::numeric_limits<double>::infinity();
    return step.reduction - 2.0 * step.parameters - 2.0 * std::log(static_cast<double>(step.candidate.settings));
  };
  double best_worth = worth(steps[0]);
  for (const ChosenStep& step : steps) best_worth = std::max(best_worth, worth(step));
  const auto nearer = [&](const ChosenStep& a, const ChosenStep& b) {
    const bool a_best = worth(a) >= best_worth - kTwins, b_best = worth(b) >= best_worth - kTwins;
    if (a_best != b_best) return a_best;
    return a.candidate.place < b.candidate.place;
  };
  return *std::min_element(steps.begin(), steps.end(), nearer);
}

bool IsParameterOf(const EffectSpec& spec, const std::string& name) {
  const std::string home = spec.effect == "gravity_compensator" ? "compensator" : spec.Path();
  return name.rfind(home + "/", 0) == 0;
}

std::vector<ScreenedCandidate> Screen(const DiagnosedModel& model, const std::vector<Candidate>& candidates) {
  const CalibrationProblem& problem = *model.problem;
  const ParameterSet& parameters = model.estimate.parameters;
  const ProjectedResidual residual(LinearizeEstimate(problem, parameters));
  const CandidateBench bench(problem, parameters, candidates);
  const Screening screening(bench, residual, problem.robot.gravity_compensator.has_value());
  const double left = model.estimate.chi2 / std::max(1, model.estimate.dof);
  const int tests = static_cast<int>(candidates.size());
  std::vector<ScreenedCandidate> screened;
  for (size_t i = 0; i < candidates.size(); ++i) {
    ScreenedCandidate entry{candidates[i], {}, 1.0, {candidates[i].spec}, {}};
    CandidateScore scored = screening.Of(static_cast<int>(i));
    entry.score = scored.score;
    entry.candidate.vague = std::move(scored.vague);
    entry.candidate.oversized = scored.oversized;
    if (candidates[i].spec.effect == "gravity_compensator") TakeStarts(scored.shapes, &entry);
    const int dof = model.estimate.dof - entry.score.rank;
    const double after = (model.estimate.chi2 - entry.score.reduction) / std::max(1, dof);
    if (entry.score.rank > 0) {
      entry.corrected_p = CorrectedP(entry.score.reduction, entry.score.rank, std::min(left, after), dof, tests);
    }
    screened.push_back(std::move(entry));
  }
  std::stable_sort(screened.begin(), screened.end(), [](const auto& a, const auto& b) {
    if ((a.score.rank > 0) != (b.score.rank > 0)) return a.score.rank > 0;
    return a.score.penalised > b.score.penalised;
  });
  return screened;
}

DiagnosedModel Extend(const DiagnosedModel& model, const std::vector<Candidate>& added, const JointOptions& options) {
  DiagnosedModel extended;
  extended.problem = std::make_shared<CalibrationProblem>(ExtendedProblem(model, added));
  const QuickRefit quick = RefitQuickly(*extended.problem, extended.problem->parameters);
  if (!quick.converged || !TellsAll(quick)) {
    const ParameterSet& start = extended.problem->parameters;
    return JudgeFully(extended.problem, start, start, options);
  }
  extended.estimate = QuickEstimate(quick);
  return extended;
}

std::vector<Candidate> CandidatesOf(const std::vector<ChosenStep>& steps) {
  std::vector<Candidate> candidates;
  for (const ChosenStep& step : steps) candidates.push_back(step.candidate);
  return candidates;
}

double PenalisedTotal(const DiagnosedModel& baseline, const DiagnosedModel& model,
                      const std::vector<ChosenStep>& steps) {
  double total = baseline.estimate.chi2 - model.estimate.chi2;
  for (const ChosenStep& step : steps) total -= Penalty(baseline, step.parameters, step.candidate.settings);
  return total;
}

std::vector<ChosenStep> SelectEffects(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates,
                                      const SelectionOptions& options, const std::vector<ChosenStep>& start,
                                      DiagnosedModel* model) {
  StepsAndModel now{start, start.empty() ? baseline : Extend(baseline, CandidatesOf(start), options.joint)};
  if (!IsUsable(now.model.estimate.status)) now = {{}, baseline};
  std::vector<Candidate> open = candidates;
  while (static_cast<int>(now.steps.size()) < options.most_steps) {
    std::optional<StepsAndModel> more = Grown(baseline, options, now, &open);
    if (!more) break;
    now = std::move(*more);
    const std::string path = now.steps.back().candidate.spec.Path();
    if (options.progress) options.progress("step " + std::to_string(now.steps.size()) + ": " + path);
    const bool loses = PenalisedTotal(baseline, now.model, now.steps) < options.decoy_gain;
    if (options.decoy_explains_all && now.steps.size() >= 3 && loses) break;
  }
  for (int pass = 0; now.steps.size() > kSwappedAtOnce && pass < 2; ++pass) {
    if (!SwapOne(baseline, open, options, &now)) break;
  }
  *model = std::move(now.model);
  return now.steps;
}

}  // namespace sagitta
