#include "estimator/diagnosis/noise_book.h"

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/noise_check.h"
#include "estimator/distributions.h"

namespace sagitta {
namespace {

constexpr double kShareOfOutliers = 0.1;  // of the significance; the scale has the same
constexpr double kSettled = 0.05;         // of sigma and repeatability
constexpr int kMostOutlierRounds = 12;

}  // namespace

double EvidenceNeeded(double significance) { return 10.0 + 2.0 * std::log(0.01 / significance); }

NoiseBook::NoiseBook(const CalibrationProblem& problem, double significance, const JointOptions& joint)
    : stated_(problem),
      significance_(significance),
      joint_(joint),
      sigma_is_stated_(problem.sigma_is_stated()),
      repeatability_is_stated_(!problem.latent.empty()) {
  finding_.is_stated = sigma_is_stated_;
}

bool NoiseBook::Replace(const CalibrationProblem& problem, DiagnosedModel* model) const {
  DiagnosedModel refit = RefitFully(problem, model->estimate, joint_);
  const bool usable = IsUsable(refit.estimate.status);
  if (usable) *model = std::move(refit);
  return usable;
}

void NoiseBook::Prepare(DiagnosedModel* baseline) {
  if (!sigma_is_stated_) {  // the baseline's own scatter is what is compared with
    CalibrationProblem scattered = *baseline->problem;
    scattered.experiment.noise.sigma = baseline->estimate.sigma.estimated;
    Replace(scattered, baseline);
  }
  for (int round = 0; round < kMostOutlierRounds && MoveOutliers(*baseline, baseline); ++round) {
  }
  const double scale = sigma_is_stated_ ? FindScale(*baseline) : 1.0;
  if (scale != 1.0 && Replace(WithScaledSigmas(*baseline->problem, scale), baseline)) applied_ = scale;
}

void NoiseBook::AddRepeatability(double rival, DiagnosedModel* baseline) {
  const double found = FindRepeatability(*baseline, rival);
  if (found > 0.0) Replace(WithRepeatability(*baseline->problem, found), baseline);
}

bool NoiseBook::Follow(const DiagnosedModel& extended, double unnamed, DiagnosedModel* baseline) {
  const bool moved = MoveOutliers(extended, baseline);
  return FollowNoise(extended, unnamed, baseline) || moved;
}

void NoiseBook::SetAsideHeldOut(DiagnosedModel* baseline, DiagnosedModel* final) {
  CalibrationProblem cleaned = *final->problem;
  std::vector<int> removed;
  for (int round = 0; round < kMostOutlierRounds; ++round) {
    const std::vector<int> outliers =
        FindOutliers(cleaned, final->estimate.parameters, cleaned.ValidationObservations(),
                     kShareOfOutliers * significance_, true, removed.size());
    if (outliers.empty()) break;
    for (const int i : outliers) cleaned.data.observations[i].excluded = true;
    removed.insert(removed.end(), outliers.begin(), outliers.end());
  }
  if (removed.empty()) return;
  CalibrationProblem before = *baseline->problem;
  for (const int i : removed) before.data.observations[i].excluded = true;
  if (!Replace(before, baseline) || !Replace(cleaned, final)) return;
  outliers_.insert(outliers_.end(), removed.begin(), removed.end());
  finding_.outliers_held_out = static_cast<int>(removed.size());
}

bool NoiseBook::Close(const Estimate& final, bool has_structure, double significance) {
  for (const int i : outliers_) finding_.outliers.push_back(stated_.data.SourceOf(stated_.data.observations[i]));
  finding_.is_finding = finding_.repeatability > 0.0 || finding_.scale_differs;
  if (scale_is_measured_ || final.dof <= 0) return false;
  const double scatter = std::sqrt(final.chi2 / final.dof);
  finding_.is_bound = has_structure;
  finding_.scale = has_structure ? std::min(1.0, scatter) : scatter;
  // A sigma from repeats is known within their own freedom: chi2 / dof is F there.
  const bool from_repeats = stated_.repeat_scatter.has_value();
  const double of_repeats = from_repeats ? stated_.repeat_scatter->DofOfAllAxes() : 0.0;
  const auto yardstick = [&](double p) {
    return from_repeats ? FQuantile(p, final.dof, of_repeats) : ChiSquareQuantile(p, final.dof) / final.dof;
  };
  finding_.low = has_structure ? 0.0 : scatter / std::sqrt(yardstick(0.975));
  finding_.high = scatter / std::sqrt(yardstick(0.025));
  if (!sigma_is_stated_ || has_structure) return false;
  const double upper = from_repeats ? FSurvival(final.chi2 / final.dof, final.dof, of_repeats)
                                    : ChiSquareSurvival(final.chi2, final.dof);
  finding_.scale_differs = std::min(upper, 1.0 - upper) < significance;
  finding_.is_finding |= finding_.scale_differs;
  return finding_.scale_differs;
}

// Scale of the instrument's noise from the markers' rigidity, over what is stated; a
// wrong one is put right before anything is named. Returns the scale that should be applied.
double NoiseBook::FindScale(const DiagnosedModel& model) {
  const CalibrationProblem stated = WithScaledSigmas(*model.problem, 1.0 / applied_);
  const auto scale = InstrumentNoiseScale(stated, model.estimate.parameters, kShareOfOutliers * significance_);
  if (!scale) return 1.0;
  scale_is_measured_ = true;
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
  const bool found = penalised > std::max(EvidenceNeeded(significance_), at_least);
  finding_.repeatability = found ? fit.sigma : 0.0;
  finding_.repeatability_low = found ? fit.low : 0.0;
  finding_.repeatability_high = found ? fit.high : 0.0;
  return finding_.repeatability;
}

// Rows that are outliers to the model leave the baseline; those that were outliers only to a model that lacked
// something come back, and stay.
bool NoiseBook::MoveOutliers(const DiagnosedModel& model, DiagnosedModel* baseline) {
  const CalibrationProblem& seen = *model.problem;
  const ParameterSet& parameters = model.estimate.parameters;
  const double significance = kShareOfOutliers * significance_;
  const std::vector<int> back = ExplainedOutliers(seen, parameters, outliers_, significance);
  std::vector<int> out =
      FindOutliers(seen, parameters, seen.CalibrationObservations(), significance, false, outliers_.size());
  const auto came_back = [&](int i) { return returned_.count(i) > 0; };
  out.erase(std::remove_if(out.begin(), out.end(), came_back), out.end());
  if (back.empty() && out.empty()) return false;
  CalibrationProblem problem = *baseline->problem;
  for (const int i : back) problem.data.observations[i].excluded = false;
  for (const int i : out) problem.data.observations[i].excluded = true;
  if (!Replace(problem, baseline)) return false;
  for (const int i : back) outliers_.erase(std::find(outliers_.begin(), outliers_.end(), i));
  returned_.insert(back.begin(), back.end());
  outliers_.insert(outliers_.end(), out.begin(), out.end());
  return true;
}

bool NoiseBook::FollowNoise(const DiagnosedModel& extended, double unnamed, DiagnosedModel* baseline) {
  CalibrationProblem problem = *baseline->problem;
  bool changed = false;
  const double scale_now = sigma_is_stated_ ? FindScale(extended) : 1.0;
  const bool scales = std::abs(scale_now / applied_ - 1.0) > kSettled;
  if (scales) problem = WithScaledSigmas(problem, scale_now / applied_);
  if (!sigma_is_stated_) {
    const double scale = std::sqrt(extended.estimate.chi2 / std::max(1, extended.estimate.dof));
    changed = std::abs(scale - 1.0) > kSettled;
    if (changed) problem = WithScaledSigmas(problem, scale);
  }
  if (!repeatability_is_stated_) {
    const double before = finding_.repeatability;
    const double now = FindRepeatability(extended, unnamed);
    const bool differs = std::abs(now - before) > kSettled * std::max(now, before);
    if (differs) problem = WithRepeatability(problem, now);
    changed |= differs;
  }
  if ((!changed && !scales) || !Replace(problem, baseline)) return false;
  if (scales) applied_ = scale_now;
  return true;
}

}  // namespace sagitta
