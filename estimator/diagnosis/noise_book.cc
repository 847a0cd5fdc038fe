#include "estimator/diagnosis/noise_book.h"

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/noise_check.h"
#include "estimator/distributions.h"

namespace sagitta {
namespace {

constexpr double kShareOfOutliers = 0.1;  // of the significance; the scale has the same
constexpr double kShareOfQuiet = 0.25;
constexpr double kSettled = 0.05;  // of sigma and repeatability
constexpr int kMostOutlierRounds = 12;

}  // namespace

NoiseBook::NoiseBook(const CalibrationProblem& problem, double significance, const JointOptions& joint)
    : stated_(problem),
      significance_(significance),
      joint_(joint),
      sigma_is_stated_(problem.sigma_is_stated()),
      repeatability_is_stated_(!problem.latent.empty()) {}

void NoiseBook::Prepare(DiagnosedModel* baseline) {
  if (!sigma_is_stated_) {  // the baseline's own scatter is what is compared with
    CalibrationProblem scattered = *baseline->problem;
    scattered.experiment.noise.sigma = baseline->estimate.sigma.estimated;
    *baseline = RefitFully(scattered, baseline->estimate, joint_);
  }
  for (int round = 0; round < kMostOutlierRounds; ++round) {
    const CalibrationProblem& problem = *baseline->problem;
    const std::vector<int> outliers =
        FindOutliers(problem, baseline->estimate.parameters, problem.CalibrationObservations(),
                     kShareOfOutliers * significance_, false);
    if (outliers.empty()) break;
    CalibrationProblem cleaned = problem;
    for (const int i : outliers) cleaned.data.observations[i].excluded = true;
    outliers_.insert(outliers_.end(), outliers.begin(), outliers.end());
    *baseline = RefitFully(cleaned, baseline->estimate, joint_);
  }
  if (sigma_is_stated_) applied_ = FindScale(*baseline);
  if (applied_ == 1.0) return;
  *baseline = RefitFully(WithScaledSigmas(*baseline->problem, applied_), baseline->estimate, joint_);
}

void NoiseBook::AddRepeatability(double rival, DiagnosedModel* baseline) {
  const double found = FindRepeatability(*baseline, rival);
  if (found <= 0.0) return;
  *baseline = RefitFully(WithRepeatability(*baseline->problem, found), baseline->estimate, joint_);
}

bool NoiseBook::Follow(const DiagnosedModel& extended, double unnamed, DiagnosedModel* baseline) {
  const bool back = BringBackOutliers(extended, baseline);
  const bool other = FollowNoise(extended, unnamed, baseline);
  return (back || other) && IsUsable(baseline->estimate.status);
}

void NoiseBook::SetAsideHeldOut(DiagnosedModel* baseline, DiagnosedModel* final) {
  CalibrationProblem cleaned = *final->problem;
  std::vector<int> removed;
  for (int round = 0; round < kMostOutlierRounds; ++round) {
    const std::vector<int> outliers = FindOutliers(
        cleaned, final->estimate.parameters, cleaned.ValidationObservations(), kShareOfOutliers * significance_, true);
    if (outliers.empty()) break;
    for (const int i : outliers) cleaned.data.observations[i].excluded = true;
    removed.insert(removed.end(), outliers.begin(), outliers.end());
  }
  if (removed.empty()) return;
  CalibrationProblem before = *baseline->problem;
  for (const int i : removed) before.data.observations[i].excluded = true;
  *baseline = RefitFully(before, baseline->estimate, joint_);
  *final = RefitFully(cleaned, final->estimate, joint_);
  outliers_.insert(outliers_.end(), removed.begin(), removed.end());
  finding_.outliers_held_out = static_cast<int>(removed.size());
}

void NoiseBook::Close(const Estimate& final) {
  for (const int i : outliers_) finding_.outliers.push_back(stated_.data.SourceOf(stated_.data.observations[i]));
  finding_.is_finding = finding_.repeatability > 0.0 || finding_.scale_differs;
  if (!sigma_is_stated_ || finding_.scale != 1.0 || final.dof <= 0) return;
  if (1.0 - ChiSquareSurvival(final.chi2, final.dof) > kShareOfQuiet * significance_) return;
  finding_.scale = std::sqrt(final.chi2 / final.dof);
  finding_.low = std::sqrt(final.chi2 / ChiSquareQuantile(0.975, final.dof));
  finding_.high = std::sqrt(final.chi2 / ChiSquareQuantile(0.025, final.dof));
  finding_.is_finding = true;
}

// Scale of the instrument's noise from the markers' rigidity, over what is stated; a
// wrong one is put right before anything is named. Returns the scale that should be applied.
double NoiseBook::FindScale(const DiagnosedModel& model) {
  const CalibrationProblem stated = WithScaledSigmas(*model.problem, 1.0 / applied_);
  const auto scale = InstrumentNoiseScale(stated, model.estimate.parameters, kShareOfOutliers * significance_);
  if (!scale) return 1.0;
  finding_.scale = scale->scale;
  finding_.low = scale->low;
  finding_.high = scale->high;
  finding_.scale_differs = scale->differs;
  return scale->differs ? scale->scale : 1.0;
}

// Undeclared repeatability that the model's residuals ask for, rad; 0: none.
double NoiseBook::FindRepeatability(const DiagnosedModel& model, double at_least) {
  const RepeatabilityFit fit = FitRepeatability(*model.problem, model.estimate.parameters);
  const double penalised = fit.gain - std::log(static_cast<double>(model.estimate.rows));
  const bool found = penalised > std::max(kNoiseEvidence, at_least);
  finding_.repeatability = found ? fit.sigma : 0.0;
  finding_.repeatability_low = found ? fit.low : 0.0;
  finding_.repeatability_high = found ? fit.high : 0.0;
  return finding_.repeatability;
}

// Rows that were outliers only to a model that lacked something come back.
bool NoiseBook::BringBackOutliers(const DiagnosedModel& extended, DiagnosedModel* baseline) {
  const std::vector<int> explained =
      ExplainedOutliers(*extended.problem, extended.estimate.parameters, outliers_, kShareOfOutliers * significance_);
  if (explained.empty()) return false;
  CalibrationProblem problem = *baseline->problem;
  for (const int i : explained) {
    problem.data.observations[i].excluded = false;
    outliers_.erase(std::find(outliers_.begin(), outliers_.end(), i));
  }
  *baseline = RefitFully(problem, baseline->estimate, joint_);
  return true;
}

bool NoiseBook::FollowNoise(const DiagnosedModel& extended, double unnamed, DiagnosedModel* baseline) {
  CalibrationProblem problem = *baseline->problem;
  bool changed = false;
  const double scale_now = sigma_is_stated_ ? FindScale(extended) : 1.0;
  if (std::abs(scale_now / applied_ - 1.0) > kSettled) {
    problem = WithScaledSigmas(problem, scale_now / applied_);
    applied_ = scale_now;
    changed = true;
  }
  if (!sigma_is_stated_) {
    const double scale = std::sqrt(extended.estimate.chi2 / std::max(1, extended.estimate.dof));
    changed = std::abs(scale - 1.0) > kSettled;
    if (changed) problem = WithScaledSigmas(problem, scale);
  }
  if (!repeatability_is_stated_) {
    const double before = finding_.repeatability;
    const double now = FindRepeatability(extended, unnamed);
    if (std::abs(now - before) > kSettled * std::max(now, before)) {
      problem = WithRepeatability(problem, now);
      changed = true;
    }
  }
  if (changed) *baseline = RefitFully(problem, baseline->estimate, joint_);
  return changed;
}

}  // namespace sagitta
