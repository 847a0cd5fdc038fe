#include "estimator/diagnosis/diagnose.h"

#include <algorithm>

#include "estimator/diagnosis/cautions.h"
#include "estimator/least_squares/parallel.h"

namespace sagitta {
namespace {

constexpr double kShareOfNaming = 0.25;     // of the significance; lack of fit and decoys have their own shares
constexpr double kShareOfLackOfFit = 0.15;  // beside it: the decoys, and the shares of the noise (noise_book.cc)
constexpr int kMostNoiseRounds = 3;
constexpr int kManyRows = 3000;

// Whether the model with the decoy's kind fits the stated noise.
bool LeavesNothing(const DiagnosedModel& model, const DecoyBench& bench, const Decoy& decoy) {
  const Eigen::MatrixXd columns = bench.ColumnsOfKind(decoy);
  const ProjectedResidual rest = bench.residual().With(columns);
  const int dof = model.estimate.dof - static_cast<int>(columns.cols());
  return dof > 0 && rest.residual().squaredNorm() < 1.2 * dof;
}

// What is chosen beside one model of the noise. Where only the common sigma followed, the same steps are the start
// again; and where there are many rows, which name the same steps whatever the noise.
void SelectAndKeep(const DiagnosedModel& baseline, const std::vector<Candidate>& candidates, bool sigma_is_stated,
                   double significance, SelectionOptions* selection, std::vector<ChosenStep>* steps,
                   Diagnosis* diagnosis) {
  const DecoyBench bench(baseline);
  const Decoy decoy = bench.Best();
  selection->decoy_gain = decoy.penalised - kUnknownMargin;
  selection->decoy_explains_all = sigma_is_stated && LeavesNothing(baseline, bench, decoy);
  if (sigma_is_stated && baseline.estimate.rows < kManyRows) steps->clear();
  *steps = SelectEffects(baseline, candidates, *selection, *steps, &diagnosis->final);
  diagnosis->has_unexplained = false;
  if (steps->empty()) return;
  if (selection->progress) selection->progress("decoys against the steps, " + std::to_string(steps->size()));
  const Unexplained rest = KeepWhatHolds(baseline, candidates, *selection, steps, &diagnosis->final);
  // What was found beside the decoy may have taken its place.
  const bool stands = steps->empty() || rest.decoy.penalised > EvidenceNeeded(significance);
  diagnosis->has_unexplained = rest.found && stands;
  diagnosis->unexplained = rest.decoy;
}

// What the first `count` steps do: on the hold-out, and to chi-square.
void MeasurePrefix(const std::vector<ChosenStep>& chosen, size_t count, const SelectionOptions& selection,
                   const DiagnosedModel& baseline, const DiagnosedModel& final, DiagnosisStep* result) {
  const std::vector<ChosenStep> first(chosen.begin(), chosen.begin() + static_cast<long>(count));
  const bool is_whole = count == chosen.size();
  const DiagnosedModel here = is_whole ? final : Extend(baseline, CandidatesOf(first), selection.joint);
  if (!IsUsable(here.estimate.status)) return;
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
  ParallelFor(static_cast<int>(chosen.size()), selection.num_threads, [&](int i, int) {
    DiagnosisStep& result = steps[i];
    result.chosen = chosen[i];
    MeasurePrefix(chosen, i + 1, selection, diagnosis->baseline, diagnosis->final, &result);
    const Eigen::VectorXd neutral_residual = bench.NeutralResidual(chosen[i]);
    result.alternatives = FindAlternatives(bench, chosen[i], neutral_residual, selection.tie);
    result.confirmation = confirmation.Confirm(chosen[i], neutral_residual, selection.tie);
    result.view = ViewStep(bench, chosen[i]);
    for (const ParameterEstimate& row : diagnosis->final.estimate.table) {
      if (row.free && IsParameterOf(chosen[i].candidate.spec, row.name)) result.parameters.push_back(row);
    }
    result.lag = AllowForLag(diagnosis->final, chosen[i], &result.parameters);
  });
  double before = HoldoutRms(diagnosis->baseline);
  for (DiagnosisStep& step : steps) {
    step.holdout_before = before;
    before = step.holdout_after;
  }
}

// What the extended model was before anything was fitted: the aligned nominal robot, effects neutral. A spring without
// rate does nothing, whatever its shape.
ParameterSet AlignedWith(const std::vector<ChosenStep>& steps, const ParameterSet& extended,
                         const ParameterSet& nominal) {
  ParameterSet aligned = extended;
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(aligned.num_coordinates());
  for (int i = 0; i < aligned.num_coordinates(); ++i) {
    const std::string& name = aligned.coordinates()[i].name;
    const bool is_shape = name.rfind("compensator/", 0) == 0 && name != "compensator/Kc";
    const bool is_new = std::any_of(steps.begin(), steps.end(),
                                    [&](const ChosenStep& step) { return IsParameterOf(step.candidate.spec, name); });
    if (is_new && !is_shape) delta[i] = -aligned.Value(i);
  }
  aligned.Plus(delta);
  aligned.CopyByName(nominal);
  return aligned;
}

bool IsEstimated(const ChosenStep& step, const Estimate& estimate) {
  return std::any_of(estimate.table.begin(), estimate.table.end(), [&](const ParameterEstimate& row) {
    return row.free && IsParameterOf(step.candidate.spec, row.name);
  });
}

// The full estimator has the last word: a step with which it finds no optimum is not named, and none of which it has to
// hold every parameter.
void JudgeFinal(const DiagnosedModel& baseline, const SelectionOptions& selection, std::vector<ChosenStep>* steps,
                Diagnosis* diagnosis) {
  DiagnosedModel& final = diagnosis->final;
  while (!steps->empty()) {
    const ParameterSet aligned = AlignedWith(*steps, final.problem->parameters, baseline.estimate.aligned);
    final = JudgeFully(final.problem, final.estimate.parameters, aligned, selection.joint);
    const bool usable = IsUsable(final.estimate.status);
    const auto idle = std::find_if(steps->begin(), steps->end(),
                                   [&](const ChosenStep& step) { return !IsEstimated(step, final.estimate); });
    if (usable && idle == steps->end()) return;
    steps->erase(usable ? idle : steps->end() - 1);
    diagnosis->has_unexplained |= !usable;
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

void Decide(const DiagnosisOptions& options, NoiseBook* noise, Diagnosis* diagnosis) {
  const double gate = kShareOfLackOfFit * options.significance;
  diagnosis->final_p = noise->LackOfFit(diagnosis->final);
  if (!diagnosis->has_unexplained) {
    const Decoy rest = DecoyBench(diagnosis->final).BestInScatter();
    diagnosis->has_unexplained = rest.penalised > EvidenceNeeded(options.significance);
    diagnosis->unexplained = rest.penalised > 0.0 ? rest : Decoy();  // else no driver stands out
  }
  const bool is_sigma = noise->Close(diagnosis->final, diagnosis->has_unexplained, gate);
  diagnosis->noise = noise->finding();
  diagnosis->has_unexplained |= diagnosis->final_p < gate && !is_sigma;
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
  selection.num_threads = options.num_threads;
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
  DiagnosedModel model = FitFully(problem, options.joint);
  diagnosis.status = model.estimate.status;
  diagnosis.message = model.estimate.message;
  if (!IsUsable(model.estimate.status)) return diagnosis;
  NoiseBook noise(problem, options.significance, options.joint);
  noise.Prepare(&model);
  if (options.points_are_measured) diagnosis.cautions = CautionsOfReadings(*model.problem);
  for (const std::string& caution : FindCautions(problem, model)) diagnosis.cautions.push_back(caution);

  const CandidateList list = ListCandidates(*model.problem, model.estimate.parameters);
  diagnosis.not_testable = list.not_testable;
  SelectionOptions selection = SelectionFor(options);
  report("screening " + std::to_string(list.candidates.size()) + " candidates");
  if (!noise.repeatability_is_stated()) {
    const std::vector<ScreenedCandidate> screened = Screen(model, list.candidates);
    const double effect = screened.empty() ? 0.0 : screened[0].score.penalised;
    noise.AddRepeatability(std::max(effect, DecoyBench(model).Best().penalised), &model);
  }
  std::vector<ChosenStep> steps;
  for (int round = 0; round < kMostNoiseRounds; ++round) {
    SelectAndKeep(model, list.candidates, noise.sigma_is_stated(), options.significance, &selection, &steps,
                  &diagnosis);
    const double unnamed = diagnosis.has_unexplained ? diagnosis.unexplained.penalised : 0.0;
    const bool is_last = round + 1 == kMostNoiseRounds;
    if (!noise.Follow(diagnosis.final, unnamed, &model)) break;
    if (is_last) {  // noise that nothing states is what is found about what is named in the end
      diagnosis.final = Extend(model, CandidatesOf(steps), selection.joint);
    } else {
      report("the noise beside the effects is not what was taken: once more");
    }
  }
  diagnosis.baseline = model;
  diagnosis.baseline_p = noise.LackOfFit(model);
  diagnosis.where = FindWhere(model);
  JudgeFinal(model, selection, &steps, &diagnosis);
  noise.SetAsideHeldOut(&diagnosis.baseline, &diagnosis.final);
  diagnosis.candidates = Screen(diagnosis.baseline, list.candidates);
  RefitBest(diagnosis.baseline, selection, &diagnosis.candidates);
  report("alternatives and halves");
  FillSteps(steps, list.candidates, selection, &diagnosis);
  Decide(options, &noise, &diagnosis);
  diagnosis.gap_map = MapGap(diagnosis.baseline, diagnosis.final);
  diagnosis.gap = JudgeGap(diagnosis.baseline, diagnosis.final);
  CautionOfHoldout(diagnosis.final, diagnosis.has_unexplained, &diagnosis.cautions);
  return diagnosis;
}

}  // namespace sagitta
