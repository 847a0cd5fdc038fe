#include "estimator/diagnosis/noise_finding.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/diagnosis/noise_check.h"
#include "estimator/noise/repeat_spread.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

constexpr double kOnePercent = 1.314;   // arms of an interval of 99 % over those of 95 %: 2.576 / 1.960
constexpr double kNearlyAll = 0.999;    // of the probability: best models first
constexpr double kSettledSize = 0.005;  // of a logarithm: twenty thousand coordinates leave as much open

double MeanStated(const CalibrationProblem& stated) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < stated.latent.size(); ++i) {
    const int joint = stated.latent.joints[i];
    if (stated.robot().chain.joints[joint].type != JointType::kRevolute) continue;
    sum += stated.latent.sigmas[i];
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

// The likelihood assumes sigma to be open where nothing states it or the stated one is probably wrong: then it scales
// the whole covariance, the joints' deviations too.
double AppliedFactor(const Evidence& evidence, const WeightedModel& model) {
  const bool is_open = !evidence.IsSigmaStated() || evidence.SigmaIsWrong(model) > kEvenOdds;
  return is_open ? evidence.LikelihoodOf(model.view).Factor(evidence.ResidualOf(model)) : 1.0;
}

// Another than stated, given sigma as it is found: where sigma is wrong and the joints are not, what is stated may be
// found again.
void FindRepeatability(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& stated,
                       const DiagnosedModel& final, NoiseFinding* noise) {
  const RepeatabilityFit fit = FitRepeatability(*final.problem, final.estimate.parameters, !noise->is_stated, true);
  const double stated_size = MeanStated(stated);
  if (stated_size > 0.0 && fit.sigma > 0.0) {
    const double off = std::log(stated_size / fit.sigma);
    const double arm = std::log((off > 0.0 ? fit.high : fit.low) / fit.sigma);  // to the end of 95 %
    if (off / arm < kOnePercent) return;
  }
  const NoiseView& view = evidence.ViewOf(model);
  noise->stated_repeatability = stated_size;
  noise->repeatability = fit.sigma > 0.0 ? fit.sigma : AppliedFactor(evidence, model) * view.sigma;
  noise->repeatability_low = fit.low;
  noise->repeatability_high = fit.high;
  noise->repeatability_is_overstated = fit.high > 0.0 ? fit.high < stated_size : noise->repeatability < stated_size;
}

std::vector<GroupFinding> FindGroups(const Evidence& evidence, const WeightedModel& model, const Measurements& data) {
  std::vector<GroupFinding> found;
  const double applied = evidence.IsSigmaStated() ? AppliedFactor(evidence, model) : 1.0;
  for (const ViewedGroup& viewed : evidence.ViewOf(model).groups) {
    const ReadingGroup& group = viewed.scaled.group;
    const double factor = applied * viewed.scaled.factor, arm = std::exp(NormalQuantile(kUpperOf95) * viewed.log_sd);
    const bool is_stated_otherwise = evidence.IsSigmaStated() && (factor / arm > 1.0 || factor * arm < 1.0);
    const bool is_wrong = !group.IsDirection() || factor > 1.0;
    found.push_back(
        {group.kind, NameOf(group, data), factor, factor / arm, factor * arm, is_stated_otherwise && is_wrong});
  }
  return found;
}

}  // namespace

CalibrationProblem WithWorkingSigma(const DiagnosedModel& baseline, bool is_stated) {
  CalibrationProblem working = *baseline.problem;
  if (is_stated) return working;
  const Estimate& estimate = baseline.estimate;
  if (working.sigma_is_stated()) {
    return WithScaledSigmas(working, std::sqrt(estimate.chi2 / std::max(1, estimate.dof)));
  }
  working.mutable_experiment()->noise.sigma = estimate.sigma.estimated;
  working.noise_origin = NoiseOrigin::kFound;
  return working;
}

CalibrationProblem WithNoiseOf(const Evidence& evidence, const WeightedModel& model,
                               const CalibrationProblem& problem) {
  const NoiseView& view = evidence.ViewOf(model);
  CalibrationProblem with = problem;
  const double factor = AppliedFactor(evidence, model);
  if (view.kind == NoiseView::Kind::kVisit) with = WithRepeatability(with, factor * view.sigma);
  if (view.kind == NoiseView::Kind::kPose) {
    with = WithRepeatability(with, factor * std::hypot(view.sigma, MeanStated(problem)));
  }
  if (!view.groups.empty()) {
    with = WithScaledGroups(with, view.Scaled());
    if (with.noise_origin != NoiseOrigin::kFound) with.noise_origin = NoiseOrigin::kScaled;
  }
  if (factor != 1.0) with = WithScaledSigmas(with, factor);
  if (evidence.IsSigmaStated()) with.stated_noise_factor = factor;  // and that of rows to come
  return with;
}

double UnitOfRows(const Evidence& evidence, const WeightedModel& model) {
  const double factor = AppliedFactor(evidence, model);
  return factor * factor;
}

NoiseFinding FindNoise(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& stated,
                       const DiagnosedModel& final) {
  NoiseFinding noise;
  noise.is_stated = IsSigmaStated(stated);
  noise.asks_repeatability = stated.experiment().repeatability.IsEstimated();
  noise.is_distinguished_from_pose = evidence.columns().HasRevisits();
  double seen = 0.0;
  for (const WeightedModel& each : evidence.models()) {
    if (seen > kNearlyAll) break;
    seen += each.probability;
    const NoiseView& view = evidence.ViewOf(each);
    const bool other = view.kind == NoiseView::Kind::kVisit || !view.groups.empty();
    noise.probability += each.probability * (other ? 1.0 : evidence.SigmaIsWrong(each));
  }
  if (evidence.ViewOf(model).kind == NoiseView::Kind::kVisit) {
    FindRepeatability(evidence, model, stated, final, &noise);
  }
  noise.scale_differs = noise.is_stated && evidence.SigmaIsWrong(model) > kEvenOdds;
  const double applied =
      noise.scale_differs ? evidence.LikelihoodOf(model.view).Factor(evidence.ResidualOf(model)) : 1.0;
  std::optional<NoiseScale> scale = InstrumentNoiseScale(*final.problem, final.estimate.parameters);
  if (!scale && final.estimate.dof > 0) scale = ScaleOf(final.estimate.chi2, final.estimate.dof, stated);
  if (scale) {
    noise.scale = applied * scale->scale;
    noise.low = applied * scale->low;
    noise.high = applied * scale->high;
  }
  noise.groups = FindGroups(evidence, model, stated.data());
  noise.is_finding =
      noise.HasUndeclaredRepeatability() || noise.scale_differs ||
      std::any_of(noise.groups.begin(), noise.groups.end(), [](const GroupFinding& group) { return group.is_finding; });
  return noise;
}

// Weights and residuals go with each other: settled after a few rounds.
DiagnosedModel WithOwnRepeatability(const DiagnosedModel& model, bool is_sigma_stated, const JointOptions& options) {
  DiagnosedModel own = model;
  double last = 0.0;
  for (int round = 0; round < kMostScatterRounds; ++round) {
    const RepeatabilityFit fit = FitRepeatability(*own.problem, own.estimate.parameters, !is_sigma_stated, false);
    if (!(fit.sigma > 0.0) || !(fit.instrument > 0.0)) return own;
    if (last > 0.0 && std::abs(std::log(fit.sigma / last)) < kSettledSize) return own;
    last = fit.sigma;
    CalibrationProblem with = WithRepeatability(*own.problem, fit.sigma);
    if (!is_sigma_stated) with = WithScaledSigmas(with, fit.instrument);
    const DiagnosedModel refit = RefitFully(with, own.estimate, options);
    if (!IsUsable(refit.estimate.status)) return own;
    own = refit;
  }
  return own;
}

void NameLeftOut(const DiagnosedModel& model, const std::vector<int>& outliers, NoiseFinding* noise) {
  const Measurements& data = model.problem->data();
  for (const int i : outliers) noise->outliers.push_back(data.SourceOf(data.observations[i]));
  std::map<int, std::vector<int>> points;  // of each shot
  for (const int i : data.PointsAmong(outliers)) points[data.observations[i].shot].push_back(i);
  for (const auto& [shot, own] : points) {
    const std::vector<int>& all = data.shots[shot].observations;
    if (own.size() < 2 || own.size() < data.PointsAmong(all).size()) continue;
    const Eigen::Matrix3Xd predicted = PredictPoints(*model.problem, model.estimate.parameters, own);
    double sum = 0.0;
    for (size_t k = 0; k < own.size(); ++k)
      sum += (data.observations[own[k]].point_in_station - predicted.col(static_cast<long>(k))).squaredNorm();
    const WrongArrival arrival = {data.configurations[data.shots[shot].configuration].id,
                                  std::sqrt(sum / static_cast<double>(own.size()))};
    noise->outliers_of_arrivals += static_cast<int>(own.size());
    const auto same = std::find_if(noise->arrivals.begin(), noise->arrivals.end(), [&](const WrongArrival& other) {
      return other.configuration == arrival.configuration;
    });
    if (same == noise->arrivals.end()) {
      noise->arrivals.push_back(arrival);
    } else {
      same->off = std::max(same->off, arrival.off);
    }
  }
}

// chi^2 / dof ~ F(dof, dof of sigma). Where sigma is found from rigid bodies with chi^2_r on r degrees of freedom:
//   (chi^2 - chi^2_r) / (dof - r) over chi^2_r / r ~ F(dof - r, r).
double LackOfFit(const CalibrationProblem& stated, const DiagnosedModel& model, const NoiseFinding& noise) {
  const Estimate& estimate = model.estimate;
  if (estimate.dof <= 0) return kNotKnown;
  if (!noise.scale_differs) return ChanceOfResiduals(stated, estimate.chi2, estimate.dof);
  // Joints move bodies as a whole: what rigid bodies leave is the instrument alone, and the two sums are independent.
  const auto rigid = InstrumentNoiseScale(*model.problem, model.estimate.parameters);
  if (!rigid) return kNotKnown;
  const double pure = rigid->scale * rigid->scale;
  const int rest = estimate.dof - rigid->dof;
  if (rest <= 0) return kNotKnown;
  return FSurvival((estimate.chi2 - pure * rigid->dof) / (rest * pure), rest, rigid->dof);
}

}  // namespace sagitta
