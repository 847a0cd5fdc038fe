#include "estimator/diagnosis/diagnose.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "estimator/distributions.h"

namespace sagitta {
namespace {

constexpr double kUnknownMargin = 6.0;  // penalised lead of a decoy over as many catalogue steps
constexpr int kMostOutlierRounds = 4;
constexpr int kBootstrapDraws = 400;

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
  DiagnosedModel model;
  model.problem = std::make_shared<CalibrationProblem>(problem);
  model.estimate = EstimateFrom(*model.problem, start.parameters, options);
  return model;
}

// Where nothing states sigma, the baseline's own scatter is what is compared with.
void StateSigma(DiagnosedModel* model, const DiagnosisOptions& options) {
  if (model->problem->sigma_is_stated()) return;
  CalibrationProblem stated = *model->problem;
  stated.experiment.noise.sigma = model->estimate.sigma.estimated;
  *model = Refit(stated, model->estimate, options.joint);
}

void RemoveOutliers(DiagnosedModel* model, const DiagnosisOptions& options, NoiseFinding* noise) {
  for (int round = 0; round < kMostOutlierRounds; ++round) {
    const std::vector<int> outliers = FindOutliers(*model->problem, model->estimate, 0.1 * options.significance);
    if (outliers.empty()) return;
    CalibrationProblem cleaned = *model->problem;
    for (const int i : outliers) {
      cleaned.data.observations[i].excluded = true;
      noise->outliers.push_back(cleaned.data.SourceOf(cleaned.data.observations[i]));
    }
    *model = Refit(cleaned, model->estimate, options.joint);
  }
}

// Scale of the instrument's noise from the markers' rigidity; a wrong one is
// put right before anything is named.
void CheckScale(DiagnosedModel* model, const DiagnosisOptions& options, NoiseFinding* noise) {
  const auto scale = InstrumentNoiseScale(*model->problem, model->estimate.parameters, 0.1 * options.significance);
  if (!scale) return;
  noise->scale = scale->scale;
  noise->low = scale->low;
  noise->high = scale->high;
  if (!scale->differs) return;
  noise->is_finding = true;
  *model = Refit(WithScaledSigmas(*model->problem, scale->scale), model->estimate, options.joint);
}

// Undeclared repeatability competes with effects, and with causes outside the
// catalogue, as one more parameter.
void CheckRepeatability(DiagnosedModel* model, const DiagnosisOptions& options, double best_effect,
                        NoiseFinding* noise) {
  if (!model->problem->latent.empty()) return;
  const RepeatabilityFit fit = FitRepeatability(*model->problem, model->estimate.parameters);
  const double penalised = fit.gain - std::log(static_cast<double>(model->estimate.rows));
  if (penalised < 10.0 || penalised < best_effect || penalised < BestDecoy(*model).penalised) return;
  noise->repeatability = fit.sigma;
  noise->repeatability_low = fit.low;
  noise->repeatability_high = fit.high;
  noise->is_finding = true;
  *model = Refit(WithRepeatability(*model->problem, fit.sigma), model->estimate, options.joint);
}

// Squared hold-out residuals per configuration, m^2, and how many coordinates.
std::vector<std::pair<double, int>> HoldoutByConfiguration(const DiagnosedModel& model) {
  std::vector<std::pair<double, int>> sums(model.problem->data.configurations.size(), {0.0, 0});
  for (const int i : model.problem->ValidationObservations()) {
    const Observation& observation = model.problem->data.observations[i];
    auto& sum = sums[model.problem->data.shots[observation.shot].configuration];
    sum.first += (observation.point_in_station - model.estimate.predicted.col(i)).squaredNorm();
    sum.second += 3;
  }
  return sums;
}

double SquaredGap(const std::vector<std::pair<double, int>>& sums, const std::vector<int>& picked, double floor) {
  double sum = 0.0;
  int count = 0;
  for (const int i : picked) {
    sum += sums[i].first;
    count += sums[i].second;
  }
  return count > 0 ? std::max(0.0, sum / count - floor * floor) : 0.0;
}

// gap^2 = holdout rms^2 - floor^2; closed = 1 - after / before; interval by
// bootstrap over hold-out configurations.
void JudgeGap(Diagnosis* diagnosis) {
  const auto before = HoldoutByConfiguration(diagnosis->baseline);
  const auto after = HoldoutByConfiguration(diagnosis->final);
  const double floor = diagnosis->final.estimate.noise_floor;
  std::vector<int> held_out;
  for (size_t c = 0; c < before.size(); ++c) {
    if (before[c].second > 0) held_out.push_back(static_cast<int>(c));
  }
  const auto closed = [&](const std::vector<int>& picked) {
    const double b = SquaredGap(before, picked, floor);
    return b > 0.0 ? 1.0 - SquaredGap(after, picked, floor) / b : 0.0;
  };
  diagnosis->gap_before = std::sqrt(SquaredGap(before, held_out, floor));
  diagnosis->gap_after = std::sqrt(SquaredGap(after, held_out, floor));
  diagnosis->gap_closed = closed(held_out);
  if (diagnosis->steps.empty()) diagnosis->gap_closed = 0.0;
  if (held_out.empty() || diagnosis->steps.empty()) return;
  std::mt19937_64 random(1);
  std::vector<double> draws;
  for (int d = 0; d < kBootstrapDraws; ++d) {
    std::vector<int> picked;
    for (size_t i = 0; i < held_out.size(); ++i) picked.push_back(held_out[random() % held_out.size()]);
    draws.push_back(closed(picked));
  }
  std::sort(draws.begin(), draws.end());
  diagnosis->gap_closed_ci95 = {draws[kBootstrapDraws / 40], draws[kBootstrapDraws - 1 - kBootstrapDraws / 40]};
}

void FillSteps(const std::vector<ChosenStep>& chosen, const std::vector<Candidate>& candidates,
               const SelectionOptions& selection, Diagnosis* diagnosis) {
  std::vector<Candidate> added;
  double before = diagnosis->baseline.estimate.validation.rms;
  for (const ChosenStep& step : chosen) {
    DiagnosisStep result;
    result.chosen = step;
    added.push_back(step.candidate);
    const DiagnosedModel here = Extend(diagnosis->baseline, added, selection.joint);
    result.holdout_before = before;
    result.holdout_after = before = here.estimate.validation.rms;
    result.reduced_chi2_after = here.estimate.chi2 / std::max(1, here.estimate.dof);
    for (const ParameterEstimate& row : diagnosis->final.estimate.table) {
      if (row.free && row.name.rfind(ParametersOf(step.candidate.spec) + "/", 0) == 0) result.parameters.push_back(row);
    }
    std::vector<Candidate> others;
    for (const ChosenStep& other : chosen) {
      if (&other != &step) others.push_back(other.candidate);
    }
    const DiagnosedModel without = Extend(diagnosis->baseline, others, selection.joint);
    result.alternatives = FindAlternatives(without, step, candidates, selection.tie);
    diagnosis->steps.push_back(std::move(result));
  }
}

// Steps that stay significant beside the decoy: stacks of effects that only
// imitate it do not.
std::vector<ChosenStep> Survivors(const DiagnosedModel& partial, const Decoy& decoy,
                                  const std::vector<ChosenStep>& rest, const SelectionOptions& options, int tests) {
  ProjectedResidual residual =
      ProjectedResidual(LinearizeEstimate(*partial.problem, partial.estimate.parameters)).With(decoy.columns);
  const double left = residual.residual().squaredNorm() / std::max(1, partial.estimate.dof);
  std::vector<ChosenStep> survivors;
  for (const ChosenStep& step : rest) {
    CandidateColumns own = ColumnsOf(*partial.problem, partial.estimate.parameters, {step.candidate.spec})[0];
    DropUninformed(residual, &own);
    const Eigen::MatrixXd& columns = own.columns;
    const Score score = residual.Test(columns, step.candidate.settings);
    if (score.rank == 0 || score.penalised <= 0.0) continue;
    const double p = tests * ChiSquareSurvival(score.reduction / std::max(1.0, left), score.rank);
    if (p >= options.significance) continue;
    survivors.push_back(step);
    residual = residual.With(columns);
  }
  return survivors;
}

// A decoy that beats as many catalogue steps: part of the cause is not in the
// catalogue. Returns the steps that hold; `final` becomes the model with them.
std::vector<ChosenStep> StepsThatHold(const std::vector<ChosenStep>& steps, const SelectionOptions& options, int tests,
                                      Diagnosis* diagnosis) {
  const auto extend = [&](const std::vector<ChosenStep>& chosen) {
    return Extend(diagnosis->baseline, CandidatesOf(chosen), options.joint);
  };
  const double total = PenalisedTotal(diagnosis->baseline, diagnosis->final, steps);
  for (size_t kept = 0; kept < steps.size(); ++kept) {
    std::vector<ChosenStep> held(steps.begin(), steps.begin() + static_cast<long>(kept));
    const DiagnosedModel partial = extend(held);
    const Decoy decoy = BestDecoy(partial);
    if (PenalisedTotal(diagnosis->baseline, partial, held) + decoy.penalised <= total + kUnknownMargin) continue;
    diagnosis->has_unexplained = true;
    diagnosis->unexplained = decoy;
    const std::vector<ChosenStep> rest(steps.begin() + static_cast<long>(kept), steps.end());
    for (const ChosenStep& step : Survivors(partial, decoy, rest, options, tests)) held.push_back(step);
    diagnosis->final = extend(held);
    return held;
  }
  return steps;
}

void Decide(const DiagnosisOptions& options, Diagnosis* diagnosis) {
  const double gate = 0.25 * options.significance;
  diagnosis->final_p = LackOfFit(diagnosis->final.estimate);
  const bool rest = diagnosis->final_p < gate || diagnosis->has_unexplained;
  if (rest && !diagnosis->has_unexplained) {
    diagnosis->unexplained = BestDecoy(diagnosis->final);
    diagnosis->has_unexplained = true;
  }
  if (!diagnosis->steps.empty()) {
    diagnosis->verdict = rest ? "partly" : "explained";
  } else if (rest) {
    diagnosis->verdict = "unknown";
  } else {
    diagnosis->verdict = diagnosis->noise.is_finding || !diagnosis->noise.outliers.empty() ? "noise" : "consistent";
  }
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
  StateSigma(&model, options);
  RemoveOutliers(&model, options, &diagnosis.noise);
  CheckScale(&model, options, &diagnosis.noise);

  const CandidateList list = ListCandidates(*model.problem);
  diagnosis.not_testable = list.not_testable;
  SelectionOptions selection;
  selection.significance = 0.5 * options.significance;
  selection.joint = options.joint;
  selection.joint.progress = nullptr;
  selection.progress = options.progress;
  report("screening " + std::to_string(list.candidates.size()) + " candidates");
  diagnosis.candidates = Screen(model, list.candidates, selection.most_tests);
  const double best = diagnosis.candidates.empty() ? 0.0 : diagnosis.candidates[0].score.penalised;
  CheckRepeatability(&model, options, best, &diagnosis.noise);
  if (diagnosis.noise.repeatability > 0.0) {
    diagnosis.candidates = Screen(model, list.candidates, selection.most_tests);
  }
  diagnosis.baseline = model;
  diagnosis.baseline_p = LackOfFit(model.estimate);
  diagnosis.where = FindWhere(model);

  selection.decoy_gain = BestDecoy(model).penalised - kUnknownMargin;
  std::vector<ChosenStep> steps = SelectEffects(model, list.candidates, selection, &diagnosis.final);
  if (!steps.empty()) {
    report("decoys against " + std::to_string(steps.size()) + " steps");
    const int tests = std::min<int>(selection.most_tests, static_cast<int>(list.candidates.size()));
    steps = StepsThatHold(steps, selection, tests, &diagnosis);
  }
  report("alternatives");
  FillSteps(steps, list.candidates, selection, &diagnosis);
  Decide(options, &diagnosis);
  JudgeGap(&diagnosis);
  return diagnosis;
}

}  // namespace sagitta
