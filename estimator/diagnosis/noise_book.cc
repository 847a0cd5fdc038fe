#include "estimator/diagnosis/noise_book.h"

#include <algorithm>
#include <cmath>

#include "estimator/diagnosis/noise_check.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/noise/repeatability.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

constexpr double kShareOfOutliers = 0.1;  // of the significance; the scale has the same
constexpr double kRepeatsTail = 0.005;    // of the interval in which repeats leave their sigma open, each side
constexpr double kAxesDiffer = 0.01;
constexpr double kSettled = 0.05;  // of sigma and repeatability
constexpr int kMostOutlierRounds = 12;
constexpr double kStillRepeatability = 2.0;  // reduced chi-square: what scatters more beside it has another cause

// Bartlett's test of the three axes' variances. A few repeats make one axis look ten times better than another; what
// is weighted so would be anybody's effect.
bool AxesDiffer(const RepeatScatter& repeats) {
  const Eigen::Array3d variances = repeats.sigma.array().square();
  const double dof = repeats.dof;
  const double statistic = dof * (3.0 * std::log(variances.mean()) - variances.log().sum()) / (1.0 + 4.0 / (9.0 * dof));
  return ChiSquareSurvival(statistic, 2.0) < kAxesDiffer;
}

}  // namespace

double EvidenceNeeded(double significance) { return 10.0 + 2.0 * std::log(0.01 / significance); }

NoiseBook::NoiseBook(const CalibrationProblem& problem, double significance, const JointOptions& joint)
    : stated_(problem),
      significance_(significance),
      joint_(joint),
      sigma_is_stated_(problem.sigma_is_stated() &&
                       problem.experiment.noise.from != NoiseSpec::From::kVarianceComponents),
      repeatability_is_stated_(!problem.latent.empty()) {
  finding_.is_stated = sigma_is_stated_;
  finding_.asks_repeatability = problem.experiment.repeatability.IsEstimated();
  sigma_follows_repeatability_ =
      !sigma_is_stated_ && !repeatability_is_stated_ && (finding_.asks_repeatability || RowsShareVisits(problem));
}

bool NoiseBook::Replace(const CalibrationProblem& problem, DiagnosedModel* model) const {
  DiagnosedModel refit = RefitFully(problem, model->estimate, joint_);
  const bool usable = IsUsable(refit.estimate.status);
  if (usable) *model = std::move(refit);
  return usable;
}

void NoiseBook::Prepare(DiagnosedModel* baseline) {
  if (stated_.repeat_scatter && !AxesDiffer(*stated_.repeat_scatter)) {
    CalibrationProblem alike = *baseline->problem;
    const double sigma = stated_.repeat_scatter->sigma.norm() / std::sqrt(3.0);
    for (Matrix3<double>& root : alike.resolved_noise) root = sigma * Matrix3<double>::Identity();
    Replace(alike, baseline);
  }
  if (!sigma_is_stated_) {  // the baseline's own scatter is what is compared with
    const double scatter = Scatter(*baseline);
    CalibrationProblem scattered = *baseline->problem;
    if (scattered.sigma_is_stated()) {
      scattered = WithScaledSigmas(scattered, scatter);
    } else {
      scattered.experiment.noise.sigma = scatter * kFallbackSigma;
    }
    Replace(scattered, baseline);
  }
  for (int round = 0; round < kMostOutlierRounds && MoveOutliers(*baseline, baseline); ++round) {
  }
  const double scale = sigma_is_stated_ ? FindScale(*baseline) : 1.0;
  if (scale != 1.0 && Replace(WithScaledSigmas(*baseline->problem, scale), baseline)) applied_ = scale;
  if (RefutesRepeatability(*baseline) && Replace(WithRepeatability(*baseline->problem, 0.0), baseline)) {
    TakeRepeatabilityAs(false);
  }
}

// Joints that were said to deviate more than they do would hide what is missing.
bool NoiseBook::RefutesRepeatability(const DiagnosedModel& model) const {
  if (!repeatability_is_stated_ || !sigma_is_stated_ || finding_.asks_repeatability) return false;
  const double evidence = RepeatabilityOverstated(*model.problem, model.estimate.parameters);
  return evidence > EvidenceNeeded(significance_);
}

void NoiseBook::TakeRepeatabilityAs(bool stated) {
  repeatability_is_stated_ = stated;
  finding_.repeatability_is_overstated = !stated;
}

void NoiseBook::AddRepeatability(double rival, DiagnosedModel* baseline) {
  const double found = FindRepeatability(*baseline, rival);
  if (found <= 0.0) return;
  Replace(WithScaledSigmas(WithRepeatability(*baseline->problem, found), beside_repeatability_), baseline);
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
    for (const int i : outliers) cleaned.data.ExcludeRow(i);
    removed.insert(removed.end(), outliers.begin(), outliers.end());
  }
  if (removed.empty()) return;
  CalibrationProblem before = *baseline->problem;
  for (const int i : removed) before.data.ExcludeRow(i);
  DiagnosedModel cleaned_baseline = *baseline;  // both or none: the gap compares the same rows
  if (!Replace(before, &cleaned_baseline) || !Replace(cleaned, final)) return;
  *baseline = std::move(cleaned_baseline);
  outliers_.insert(outliers_.end(), removed.begin(), removed.end());
  finding_.outliers_held_out = static_cast<int>(removed.size());
}

double NoiseBook::LackOfFit(const DiagnosedModel& model) const {
  const Estimate& estimate = model.estimate;
  if (estimate.dof <= 0) return 1.0;
  if (finding_.scale_differs && scale_is_measured_) return BesideRigidity(model);
  const double of_sigma = SigmaDof(stated_.repeat_scatter);
  return FSurvival(OverStated(estimate) / estimate.dof, estimate.dof, of_sigma);
}

// The joints move bodies as a whole, and so do their deviations: the two sums of squares are independent.
double NoiseBook::BesideRigidity(const DiagnosedModel& model) const {
  const auto rigid = InstrumentNoiseScale(*model.problem, model.estimate.parameters, significance_);
  if (!rigid) return 1.0;
  const double pure = rigid->scale * rigid->scale;
  const int rest = model.estimate.dof - rigid->dof;
  if (rest <= 0) return 1.0;
  return FSurvival((model.estimate.chi2 - pure * rigid->dof) / (rest * pure), rest, rigid->dof);
}

bool NoiseBook::Close(const DiagnosedModel& final, bool has_structure, double significance) {
  for (const int i : outliers_) finding_.outliers.push_back(stated_.data.SourceOf(stated_.data.observations[i]));
  finding_.taken_of_repeats = IsWithinRepeats() ? applied_ : 1.0;
  const bool is_redundant = final.estimate.dof > 0;
  const double above = LackOfFit(final);
  const bool differs = sigma_is_stated_ && is_redundant && std::min(above, 1.0 - above) < significance;
  const bool is_sigma = differs && !has_structure && AllowsAnotherSigma(final, significance);
  finding_.repeatability_is_bound =
      finding_.repeatability > 0.0 && (has_structure || (above < significance && !is_sigma));
  if (finding_.repeatability_is_bound) finding_.repeatability_low = 0.0;
  if (is_redundant && (is_sigma || !scale_is_measured_)) ScaleByScatter(final.estimate, has_structure);
  finding_.scale_differs |= is_sigma;
  finding_.is_finding =
      finding_.HasUndeclaredRepeatability() || finding_.scale_differs || finding_.repeatability_is_overstated;
  return is_sigma;
}

// Whether what the markers' rigidity tells of the instrument lets the scatter of all rows be its noise.
bool NoiseBook::AllowsAnotherSigma(const DiagnosedModel& model, double significance) const {
  if (!scale_is_measured_) return true;
  if (finding_.scale_differs) return false;  // it is taken already
  const double above = BesideRigidity(model);
  return std::min(above, 1.0 - above) >= significance;
}

void NoiseBook::ScaleByScatter(const Estimate& final, bool has_structure) {
  const double scatter = std::sqrt(OverStated(final) / final.dof);
  const double of_sigma = SigmaDof(stated_.repeat_scatter);
  finding_.is_bound = has_structure;
  finding_.scale = has_structure ? std::min(1.0, scatter) : scatter;
  finding_.low = has_structure ? 0.0 : scatter / std::sqrt(FQuantile(0.975, final.dof, of_sigma));
  finding_.high = scatter / std::sqrt(FQuantile(0.025, final.dof, of_sigma));
}

// Scale of the instrument's noise from the markers' rigidity, over what is stated; a
// wrong one is put right before anything is named. Returns the scale that should be applied.
double NoiseBook::FindScale(const DiagnosedModel& model) {
  const CalibrationProblem stated = WithScaledSigmas(*model.problem, 1.0 / applied_);
  const auto scale = InstrumentNoiseScale(stated, model.estimate.parameters, kShareOfOutliers * significance_);
  if (!scale) return WithinRepeats(model.estimate);
  scale_is_measured_ = true;
  finding_.scale = scale->scale;
  finding_.low = scale->low;
  finding_.high = scale->high;
  finding_.scale_differs = scale->differs;
  return scale->differs ? scale->scale : WithinRepeats(model.estimate);
}

// Few repeats leave their sigma open: within their interval the scatter about the model says what it is. Taken as exact
// it would be too small every second time, and noise be named.
double NoiseBook::WithinRepeats(const Estimate& estimate) const {
  if (!stated_.repeat_scatter || estimate.dof <= 0) return 1.0;
  const double dof = SigmaDof(stated_.repeat_scatter);
  const double least = dof / ChiSquareQuantile(1.0 - kRepeatsTail, dof);
  const double most = dof / ChiSquareQuantile(kRepeatsTail, dof);
  return std::sqrt(std::clamp(OverStated(estimate) / estimate.dof, least, most));
}

// A scale that rigid markers have shown is what the noise is, whatever repeats say.
bool NoiseBook::IsWithinRepeats() const { return stated_.repeat_scatter && !finding_.scale_differs; }

// Chi-square in the sigma that the repeats state.
double NoiseBook::OverStated(const Estimate& estimate) const {
  return estimate.chi2 * (IsWithinRepeats() ? applied_ * applied_ : 1.0);
}

double NoiseBook::Scatter(const DiagnosedModel& model) const {
  if (repeatability_is_stated_) {
    RepeatabilityChoice choice;
    FindComponents(*model.problem, model.estimate.parameters, false, 0, &choice);
    return choice.instrument;
  }
  const Estimate& estimate = model.estimate;
  return model.problem->sigma_is_stated() ? std::sqrt(estimate.chi2 / std::max(1, estimate.dof))
                                          : estimate.sigma.estimated / kFallbackSigma;
}

// Undeclared repeatability that the model's residuals ask for, rad; 0: none, or that nothing could tell from what the
// model lacks: sigma open and every arrival seen once.
double NoiseBook::FindRepeatability(const DiagnosedModel& model, double at_least) {
  if (!sigma_is_stated_ && !sigma_follows_repeatability_) return 0.0;
  const RepeatabilityFit fit =
      FitRepeatability(*model.problem, model.estimate.parameters, sigma_follows_repeatability_);
  const double penalised = fit.gain - std::log(static_cast<double>(model.estimate.rows));
  const bool is_shown = penalised > std::max(EvidenceNeeded(significance_), at_least);
  // That there is some is stated, where less is found than that.
  const bool is_some = finding_.repeatability_is_overstated && fit.sigma > 0.0;
  const bool found = (is_shown || is_some) && fit.reduced_chi2 < kStillRepeatability;
  beside_repeatability_ = found ? fit.instrument : fit.instrument_alone;
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
  for (const int i : back) problem.data.ExcludeRow(i, false);
  for (const int i : out) problem.data.ExcludeRow(i);
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
  const bool refuted = RefutesRepeatability(extended);
  if (refuted) TakeRepeatabilityAs(false);
  if (!repeatability_is_stated_) {
    const double before = finding_.repeatability;
    const double now = FindRepeatability(extended, unnamed);
    changed = refuted || std::abs(now - before) > kSettled * std::max(now, before);
    if (changed) problem = WithRepeatability(problem, now);
  }
  if (!sigma_is_stated_) {
    const double scale = sigma_follows_repeatability_ ? beside_repeatability_ : Scatter(extended);
    const bool differs = std::abs(scale - 1.0) > kSettled;
    if (differs) problem = WithScaledSigmas(problem, scale);
    changed |= differs;
  }
  if ((!changed && !scales) || !Replace(problem, baseline)) {
    if (refuted) TakeRepeatabilityAs(true);
    return false;
  }
  if (scales) applied_ = scale_now;
  return true;
}

}  // namespace sagitta
