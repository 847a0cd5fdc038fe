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

JointSigmas MeanStated(const CalibrationProblem& stated) {
  JointSigmas sums;
  int turning = 0, sliding = 0;
  for (int i = 0; i < stated.latent.size(); ++i) {
    const bool turns = stated.robot().chain.joints[stated.latent.joints[i]].type == JointType::kRevolute;
    (turns ? sums.turn : sums.travel) += stated.latent.sigmas[i];
    ++(turns ? turning : sliding);
  }
  return {sums.turn / std::max(1, turning), sums.travel / std::max(1, sliding)};
}

// The likelihood assumes sigma to be open where nothing states it or the stated one is probably wrong: then it scales
// the whole covariance, the joints' deviations too.
double AppliedFactor(const Evidence& evidence, const WeightedModel& model) {
  return evidence.IsSigmaOpen(model) ? evidence.LikelihoodOf(model.view).Factor(evidence.ResidualOf(model)) : 1.0;
}

bool IsAsStated(const SizeFit& fit, double stated) {
  if (!(stated > 0.0) || !(fit.sigma > 0.0)) return stated == fit.sigma;
  const double off = std::log(stated / fit.sigma);
  const double arm = std::log((off > 0.0 ? fit.high : fit.low) / fit.sigma);  // to the end of 95 %
  return off / arm < kOnePercent;
}

// Another than stated, given sigma as it is found: where sigma is wrong and the joints are not, what is stated may be
// found again.
void FindRepeatability(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& stated,
                       const DiagnosedModel& final, NoiseFinding* noise) {
  RepeatabilityFit fit = FitRepeatability(*final.problem, final.estimate.parameters, !noise->is_stated, true);
  const JointSigmas size = MeanStated(stated);
  const bool is_stated = size.turn > 0.0 || size.travel > 0.0;
  if (is_stated && IsAsStated(fit.turn, size.turn) && IsAsStated(fit.travel, size.travel)) return;
  if (!fit.IsFound()) {
    const double sigma = AppliedFactor(evidence, model) * evidence.ViewOf(model).sigma;
    for (const Joint& joint : stated.robot().chain.joints) {
      (joint.type == JointType::kRevolute ? fit.turn.sigma = sigma : fit.travel.sigma = kTravelPerTurn * sigma);
    }
  }
  noise->turn = {fit.turn.sigma, fit.turn.low, fit.turn.high, size.turn};
  noise->travel = {fit.travel.sigma, fit.travel.low, fit.travel.high, size.travel};
  const auto is_over_or_none = [](const FoundRepeatability& found) {
    return found.IsOverstated() || (found.sigma == 0.0 && found.stated == 0.0);
  };
  noise->repeatability_is_overstated = is_over_or_none(noise->turn) && is_over_or_none(noise->travel);
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
  if (view.kind != NoiseView::Kind::kStated) {
    const JointSigmas stated = view.kind == NoiseView::Kind::kPose ? MeanStated(problem) : JointSigmas();
    const double as_stated = view.joints_over_sigma;
    with = WithRepeatability(with, {factor * std::hypot(view.sigma, as_stated * stated.turn),
                                    factor * std::hypot(kTravelPerTurn * view.sigma, as_stated * stated.travel)});
  }
  if (!view.groups.empty()) {
    with = WithScaledGroups(with, view.Scaled());
    if (with.noise_origin != NoiseOrigin::kFound) with.noise_origin = NoiseOrigin::kScaled;
  }
  if (factor != 1.0) with = WithScaledSigmas(with, factor);
  if (view.kind == NoiseView::Kind::kStated) with.latent.sigmas *= factor * view.joints_over_sigma;
  if (evidence.IsSigmaStated()) with.stated_noise_factor = factor;  // and that of rows to come
  return with;
}

double UnitOfRows(const Evidence& evidence, const WeightedModel& model) {
  const double factor = AppliedFactor(evidence, model);
  return factor * factor;
}

bool IsSigmaRefuted(const Evidence& evidence, double level) {
  double wrong = 0.0, other = 0.0, seen = 0.0;
  for (const WeightedModel& model : evidence.models()) {
    if (seen > kNearlyAll) break;
    seen += model.probability;
    const double residual = evidence.ResidualOf(model), own = evidence.SigmaIsWrong(model) * model.probability;
    wrong += own;
    if (evidence.LikelihoodOf(model.view).ChanceOf(residual) > level) other += model.probability - own;
  }
  return wrong > other;
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
    noise.probability += each.probability * (view.IsNoiseStated() ? evidence.SigmaIsWrong(each) : 1.0);
  }
  if (evidence.ViewOf(model).kind == NoiseView::Kind::kVisit) {
    FindRepeatability(evidence, model, stated, final, &noise);
  }
  noise.scale_differs = noise.is_stated && evidence.IsSigmaOpen(model);
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
    if (!fit.IsFound() || !(fit.instrument > 0.0)) return own;
    const double size = std::hypot(fit.turn.sigma, fit.travel.sigma / kTravelPerTurn);
    if (last > 0.0 && std::abs(std::log(size / last)) < kSettledSize) return own;
    last = size;
    CalibrationProblem with = WithRepeatability(*own.problem, fit.Sigmas());
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
