#include "estimator/diagnosis/diagnose.h"

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/cautions.h"
#include "estimator/distributions.h"
#include "estimator/parallel.h"

namespace sagitta {
namespace {

constexpr double kShareOfNaming = 0.25;  // of the significance; lack of fit and decoys have their own shares
constexpr double kNoiseEvidence = 10.0;  // penalised gain of what is no effect before it counts
constexpr double kSettled = 0.05;        // of sigma and repeatability
constexpr int kMostNoiseRounds = 3;
constexpr int kManyRows = 3000;
constexpr int kMostOutlierRounds = 12;

double LackOfFit(const Estimate& estimate) {
  return estimate.dof > 0 ? ChiSquareSurvival(estimate.chi2, estimate.dof) : 1.0;
}

DiagnosedModel Fit(const CalibrationProblem& problem, const JointOptions& options) {
  DiagnosedModel model;
  model.problem = std::make_shared<CalibrationProblem>(problem);
  model.estimate = EstimateJointly(*model.problem, options);
  return model;
}

DiagnosedModel Refit(const CalibrationProblem& problem, const Estimate& start, const JointOptions& options) {
  return JudgeFully(std::make_shared<CalibrationProblem>(problem), start.parameters, start.aligned, options);
}

// Where nothing states sigma, the baseline's own scatter is what is compared with.
void StateSigma(DiagnosedModel* model, const DiagnosisOptions& options) {
  if (model->problem->sigma_is_stated()) return;
  CalibrationProblem stated = *model->problem;
  stated.experiment.noise.sigma = model->estimate.sigma.estimated;
  *model = Refit(stated, model->estimate, options.joint);
}

// Returns the observations that are fitted no longer.
std::vector<int> RemoveOutliers(DiagnosedModel* model, const DiagnosisOptions& options) {
  std::vector<int> removed;
  for (int round = 0; round < kMostOutlierRounds; ++round) {
    const std::vector<int> outliers = FindOutliers(*model->problem, model->estimate, 0.1 * options.significance);
    if (outliers.empty()) return removed;
    CalibrationProblem cleaned = *model->problem;
    for (const int i : outliers) cleaned.data.observations[i].excluded = true;
    removed.insert(removed.end(), outliers.begin(), outliers.end());
    *model = Refit(cleaned, model->estimate, options.joint);
  }
  return removed;
}

// Rows that were outliers only to a model that lacked something come back. True when the baseline has changed.
bool BringBackOutliers(const DiagnosedModel& extended, const DiagnosisOptions& options, std::vector<int>* removed,
                       DiagnosedModel* baseline) {
  const std::vector<int> explained =
      ExplainedOutliers(*extended.problem, extended.estimate.parameters, *removed, 0.1 * options.significance);
  if (explained.empty()) return false;
  CalibrationProblem problem = *baseline->problem;
  for (const int i : explained) {
    problem.data.observations[i].excluded = false;
    removed->erase(std::find(removed->begin(), removed->end(), i));
  }
  *baseline = Refit(problem, baseline->estimate, options.joint);
  return true;
}

// Scale of the instrument's noise from the markers' rigidity, over what is stated
// (`applied` is in the model's sigmas already); a wrong one is put right before
// anything is named. Returns the scale that should be applied.
double FindScale(const DiagnosedModel& model, double applied, const DiagnosisOptions& options, NoiseFinding* noise) {
  const CalibrationProblem stated = WithScaledSigmas(*model.problem, 1.0 / applied);
  const auto scale = InstrumentNoiseScale(stated, model.estimate.parameters, 0.1 * options.significance);
  if (!scale) return 1.0;
  noise->scale = scale->scale;
  noise->low = scale->low;
  noise->high = scale->high;
  noise->scale_differs = scale->differs;
  return scale->differs ? scale->scale : 1.0;
}

// Undeclared repeatability that the model's residuals ask for, rad; 0: none.
double FindRepeatability(const DiagnosedModel& model, double at_least, NoiseFinding* noise) {
  const RepeatabilityFit fit = FitRepeatability(*model.problem, model.estimate.parameters);
  const double penalised = fit.gain - std::log(static_cast<double>(model.estimate.rows));
  const bool found = penalised > std::max(kNoiseEvidence, at_least);
  noise->repeatability = found ? fit.sigma : 0.0;
  noise->repeatability_low = found ? fit.low : 0.0;
  noise->repeatability_high = found ? fit.high : 0.0;
  return noise->repeatability;
}

// What the noise is can only be told beside the effects, and the other way
// round: sigma where nothing states it, its scale where markers tell, and joint repeatability that nobody
// declared, follow the extended model (repeatability only where it says more
// than `unnamed`, the gain of a cause outside the catalogue). True when the baseline has changed.
bool FollowNoise(const DiagnosedModel& extended, double unnamed, bool sigma_is_stated, bool repeatability_is_stated,
                 const DiagnosisOptions& options, double* applied, DiagnosedModel* baseline, NoiseFinding* noise) {
  CalibrationProblem problem = *baseline->problem;
  bool changed = false;
  const double scale_now = sigma_is_stated ? FindScale(extended, *applied, options, noise) : 1.0;
  if (std::abs(scale_now / *applied - 1.0) > kSettled) {
    problem = WithScaledSigmas(problem, scale_now / *applied);
    *applied = scale_now;
    changed = true;
  }
  if (!sigma_is_stated) {
    const double scale = std::sqrt(extended.estimate.chi2 / std::max(1, extended.estimate.dof));
    changed = std::abs(scale - 1.0) > kSettled;
    if (changed) problem = WithScaledSigmas(problem, scale);
  }
  if (!repeatability_is_stated) {
    const double before = noise->repeatability;
    const double now = FindRepeatability(extended, unnamed, noise);
    if (std::abs(now - before) > kSettled * std::max(now, before)) {
      problem = WithRepeatability(problem, now);
      changed = true;
    }
  }
  if (changed) *baseline = Refit(problem, baseline->estimate, options.joint);
  return changed && IsUsable(baseline->estimate.status);
}

// Whether the model with the decoy's kind fits the stated noise.
bool LeavesNothing(const DiagnosedModel& model, const DecoyBench& bench, const Decoy& decoy) {
  const Eigen::MatrixXd columns = bench.ColumnsOfKind(decoy);
  const ProjectedResidual rest = bench.residual().With(columns);
  const int dof = model.estimate.dof - static_cast<int>(columns.cols());
  return dof > 0 && rest.residual().squaredNorm() < 1.2 * dof;
}

// What the first `count` steps do: on the hold-out, and to chi-square.
void MeasurePrefix(const std::vector<ChosenStep>& chosen, size_t count, const SelectionOptions& selection,
                   const DiagnosedModel& baseline, DiagnosisStep* result) {
  const std::vector<ChosenStep> first(chosen.begin(), chosen.begin() + static_cast<long>(count));
  const DiagnosedModel here = Extend(baseline, CandidatesOf(first), selection.joint);
  result->holdout_after = HoldoutRms(here);
  result->reduced_chi2_after = here.estimate.chi2 / std::max(1, here.estimate.dof);
}

void FillSteps(const std::vector<ChosenStep>& chosen, const std::vector<Candidate>& candidates,
               const SelectionOptions& selection, Diagnosis* diagnosis) {
  if (chosen.empty()) return;
  const StepBench bench(diagnosis->final, candidates);
  const ConfirmationBench confirmation(bench);
  std::vector<DiagnosisStep>& steps = diagnosis->steps;
  steps.resize(chosen.size());
  ParallelFor(static_cast<int>(chosen.size()), selection.joint.num_threads, [&](int i, int) {
    DiagnosisStep& result = steps[i];
    result.chosen = chosen[i];
    MeasurePrefix(chosen, i + 1, selection, diagnosis->baseline, &result);
    const Eigen::VectorXd neutral_residual = bench.NeutralResidual(chosen[i]);
    result.alternatives = FindAlternatives(bench, chosen[i], neutral_residual, selection.tie);
    result.confirmation = confirmation.Confirm(chosen[i], neutral_residual, selection.tie);
    result.view = ViewStep(bench, chosen[i]);
    for (const ParameterEstimate& row : diagnosis->final.estimate.table) {
      if (row.free && IsParameterOf(chosen[i].candidate.spec, row.name)) result.parameters.push_back(row);
    }
  });
  double before = diagnosis->baseline.estimate.validation.rms;
  for (DiagnosisStep& step : steps) {
    step.holdout_before = before;
    before = step.holdout_after;
  }
}

// The full estimator has the last word: a step with which it finds no optimum is not named.
void JudgeFinal(const DiagnosedModel& baseline, const SelectionOptions& selection, std::vector<ChosenStep>* steps,
                Diagnosis* diagnosis) {
  DiagnosedModel& final = diagnosis->final;
  while (!steps->empty()) {
    final = JudgeFully(final.problem, final.estimate.parameters, final.problem->parameters, selection.joint);
    if (IsUsable(final.estimate.status)) return;
    steps->pop_back();
    diagnosis->has_unexplained = true;
    final = Extend(baseline, CandidatesOf(*steps), selection.joint);
  }
  final = baseline;
}

// What each of the best candidates alone does on the hold-out: for people, nothing is chosen by it.
void RefitBest(const DiagnosedModel& baseline, const SelectionOptions& selection,
               std::vector<ScreenedCandidate>* candidates) {
  if (baseline.problem->ValidationObservations().empty()) return;
  for (size_t i = 0; i < candidates->size() && static_cast<int>(i) < selection.refitted; ++i) {
    ScreenedCandidate& entry = (*candidates)[i];
    if (entry.score.rank == 0) return;
    const DiagnosedModel extended = Extend(baseline, {entry.candidate}, selection.joint);
    if (IsUsable(extended.estimate.status)) entry.holdout_rms = HoldoutRms(extended);
  }
}

// Where no rigid body of markers tells the instrument's noise, scatter that is
// too small for it does.
void CheckTooQuiet(const DiagnosisOptions& options, Diagnosis* diagnosis) {
  const Estimate& final = diagnosis->final.estimate;
  if (diagnosis->noise.scale != 1.0 || final.dof <= 0) return;
  if (1.0 - ChiSquareSurvival(final.chi2, final.dof) > 0.25 * options.significance) return;
  diagnosis->noise.scale = std::sqrt(final.chi2 / final.dof);
  diagnosis->noise.low = std::sqrt(final.chi2 / ChiSquareQuantile(0.975, final.dof));
  diagnosis->noise.high = std::sqrt(final.chi2 / ChiSquareQuantile(0.025, final.dof));
  diagnosis->noise.is_finding = true;
}

void Decide(const DiagnosisOptions& options, Diagnosis* diagnosis) {
  const double gate = 0.25 * options.significance;
  diagnosis->final_p = LackOfFit(diagnosis->final.estimate);
  if (!diagnosis->has_unexplained) {
    diagnosis->unexplained = DecoyBench(diagnosis->final).Best();
    const bool stands_out = diagnosis->unexplained.penalised > kNoiseEvidence;
    diagnosis->has_unexplained = diagnosis->final_p < gate || stands_out;
  }
  const bool noise_is_wrong = diagnosis->noise.is_finding || !diagnosis->noise.outliers.empty();
  if (!diagnosis->steps.empty()) {
    diagnosis->verdict = diagnosis->has_unexplained ? "partly" : "explained";
  } else if (diagnosis->has_unexplained) {
    diagnosis->verdict = "unknown";
  } else {
    diagnosis->verdict = noise_is_wrong ? "noise" : "consistent";
  }
}

SelectionOptions SelectionFor(const DiagnosisOptions& options) {
  SelectionOptions selection;
  selection.significance = kShareOfNaming * options.significance;
  selection.joint = options.joint;
  selection.joint.progress = nullptr;
  selection.progress = options.progress;
  return selection;
}

}  // namespace

Diagnosis Diagnose(const CalibrationProblem& problem, const DiagnosisOptions& options) {
  const auto report = [&](const std::string& words) {
    if (options.progress) options.progress(words);
  };
  Diagnosis diagnosis;
  report("fitting the believed model");
  DiagnosedModel model = Fit(problem, options.joint);
  diagnosis.status = model.estimate.status;
  diagnosis.message = model.estimate.message;
  if (!IsUsable(model.estimate.status)) return diagnosis;
  const bool sigma_is_stated = problem.sigma_is_stated();
  const bool repeatability_is_stated = !problem.latent.empty();
  NoiseFinding& noise = diagnosis.noise;
  diagnosis.cautions = FindCautions(model);
  StateSigma(&model, options);
  std::vector<int> outliers = RemoveOutliers(&model, options);
  double applied = sigma_is_stated ? FindScale(model, 1.0, options, &noise) : 1.0;
  if (applied != 1.0) model = Refit(WithScaledSigmas(*model.problem, applied), model.estimate, options.joint);

  const CandidateList list = ListCandidates(*model.problem);
  diagnosis.not_testable = list.not_testable;
  SelectionOptions selection = SelectionFor(options);
  report("screening " + std::to_string(list.candidates.size()) + " candidates");
  diagnosis.candidates = Screen(model, list.candidates, selection.most_tests);
  if (!repeatability_is_stated) {
    const double effect = diagnosis.candidates.empty() ? 0.0 : diagnosis.candidates[0].score.penalised;
    const double found = FindRepeatability(model, std::max(effect, DecoyBench(model).Best().penalised), &noise);
    if (found > 0.0) model = Refit(WithRepeatability(*model.problem, found), model.estimate, options.joint);
  }
  std::vector<ChosenStep> steps;
  for (int round = 0; round < kMostNoiseRounds; ++round) {
    const DecoyBench bench(model);
    const Decoy decoy = bench.Best();
    selection.decoy_gain = decoy.penalised - kUnknownMargin;
    selection.decoy_explains_all = sigma_is_stated && LeavesNothing(model, bench, decoy);
    // Where only the common sigma followed, the same steps are the start again; and where there are many rows, which
    // name the same steps whatever the noise.
    if (sigma_is_stated && model.estimate.rows < kManyRows) steps.clear();
    steps = SelectEffects(model, list.candidates, selection, steps, &diagnosis.final);
    diagnosis.has_unexplained = false;
    if (!steps.empty()) {
      report("decoys against " + std::to_string(steps.size()) + " steps");
      const Unexplained rest = KeepWhatHolds(model, list.candidates, selection, &steps, &diagnosis.final);
      diagnosis.has_unexplained = rest.found;
      diagnosis.unexplained = rest.decoy;
    }
    if (round + 1 == kMostNoiseRounds) break;
    const double unnamed = diagnosis.has_unexplained ? diagnosis.unexplained.penalised : 0.0;
    const bool back = BringBackOutliers(diagnosis.final, options, &outliers, &model);
    const bool other = FollowNoise(diagnosis.final, unnamed, sigma_is_stated, repeatability_is_stated, options,
                                   &applied, &model, &noise);
    if ((!back && !other) || !IsUsable(model.estimate.status)) break;
    report("the noise beside the effects is not what was taken: once more");
  }
  noise.is_finding |= noise.repeatability > 0.0 || noise.scale_differs;
  for (const int i : outliers) noise.outliers.push_back(problem.data.SourceOf(problem.data.observations[i]));
  diagnosis.candidates = Screen(model, list.candidates, selection.most_tests);
  RefitBest(model, selection, &diagnosis.candidates);
  diagnosis.baseline = model;
  diagnosis.baseline_p = LackOfFit(model.estimate);
  diagnosis.where = FindWhere(model);
  JudgeFinal(model, selection, &steps, &diagnosis);
  report("alternatives and halves");
  FillSteps(steps, list.candidates, selection, &diagnosis);
  if (sigma_is_stated) CheckTooQuiet(options, &diagnosis);
  Decide(options, &diagnosis);
  diagnosis.gap = JudgeGap(diagnosis.baseline, diagnosis.final);
  if (steps.empty()) diagnosis.gap.closed = 0.0;
  return diagnosis;
}

}  // namespace sagitta
