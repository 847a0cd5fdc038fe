#include "estimator/diagnosis/gap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <random>
#include <vector>

#include "estimator/least_squares/linearization.h"
#include "estimator/noise/repeat_spread.h"
#include "estimator/statistics/distributions.h"
#include "estimator/validation/trust.h"
#include "models/constants.h"
#include "problems/significance.h"
#include "problems/split.h"

namespace sagitta {
namespace {

constexpr double kWorseBeyondChance = kDefaultSignificance;
constexpr double kBetterBeyondChance = 0.05;  // as of an effect's interval: neither may say that it is chance
// Of the significance: asked in addition to the posterior and to lack of fit (kShareOfLackOfFit in diagnose.cc).
constexpr double kShareOfHoldout = 0.1;
constexpr int kSignDraws = 1999;    // a chance of 5 % is known to 0.5 % ...
constexpr int kSignsAsLarge = 200;  // ... and one of 10 % and more is known enough
constexpr unsigned kSeedOfSigns = 1;
constexpr int kBeyondAnEnd = 10;                    // draws: they say where an end of an interval of 95 % lies ...
constexpr int kBootstrapDraws = 40 * kBeyondAnEnd;  // ... to a third of 2.5 %

std::vector<int> PointsHeldOut(const DiagnosedModel& model) {
  return model.problem->data().PointsAmong(model.problem->ValidationObservations());
}

int Count(const HoldoutSums& sums) { return static_cast<int>((sums.coordinates.array() > 0.0).count()); }

// P that the sum would be as large if each difference had either sign alike (Fisher 1935, The Design of Experiments,
// section 21), from draws of which kSignsAsLarge are enough (Besag and Clifford, Biometrika 78 (1991) 301).
double ChanceBySigns(const Eigen::VectorXd& of_configurations) {
  std::vector<double> differences;  // of those that are held out
  std::copy_if(of_configurations.begin(), of_configurations.end(), std::back_inserter(differences),
               [](double difference) { return difference != 0.0; });
  std::mt19937_64 random(kSeedOfSigns);
  const double sum = of_configurations.sum();
  int as_large = 0;
  for (int draw = 0; draw < kSignDraws; ++draw) {
    double drawn = 0.0;
    std::uint64_t signs = 0;
    for (size_t k = 0; k < differences.size(); ++k) {
      if (k % 64 == 0) signs = random();
      drawn += (signs >> (k % 64)) % 2 == 0 ? differences[k] : -differences[k];
    }
    as_large += drawn >= sum ? 1 : 0;
    if (as_large == kSignsAsLarge) return static_cast<double>(as_large) / (1.0 + draw);
  }
  return (1.0 + as_large) / (1.0 + kSignDraws);
}

// Of picked configurations: max(0, sum |r|^2 / n - floor^2), n coordinates.
double SquaredGap(const HoldoutSums& sums, const std::vector<int>& picked, double floor) {
  double sum = 0.0, count = 0.0;
  for (const int i : picked) {
    sum += sums.squares[i];
    count += sums.coordinates[i];
  }
  return count > 0.0 ? std::max(0.0, sum / count - floor * floor) : 0.0;
}

}  // namespace

HoldoutSums SumHoldout(const DiagnosedModel& model) {
  const Measurements& data = model.problem->data();
  const std::vector<int> held_out = PointsHeldOut(model);
  const Eigen::Matrix3Xd& known = model.estimate.predicted;
  const Eigen::Matrix3Xd predicted = known.size() > 0
                                         ? Eigen::Matrix3Xd(known(Eigen::all, held_out))
                                         : PredictPoints(*model.problem, model.estimate.parameters, held_out);
  const Eigen::Matrix3Xd misfit = ResidualsOf(data, held_out, predicted);
  const std::vector<int> group_of = GroupsOfConfigurations(data);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(data.configurations.size());
  HoldoutSums sums{none, none};
  for (size_t k = 0; k < held_out.size(); ++k) {
    const int c = group_of[data.shots[data.observations[held_out[k]].shot].configuration];
    sums.squares[c] += misfit.col(k).squaredNorm();
    sums.coordinates[c] += 3.0;
  }
  return sums;
}

int CountHeldOut(const DiagnosedModel& model) { return Count(SumHoldout(model)); }

double HoldoutRms(const DiagnosedModel& model) {
  const HoldoutSums sums = SumHoldout(model);
  return std::sqrt(sums.squares.sum() / sums.coordinates.sum());
}

DiagnosedModel PredictingHoldout(DiagnosedModel model) {
  Eigen::Matrix3Xd& predicted = model.estimate.predicted;
  if (!IsUsable(model.estimate.status) || predicted.size() > 0) return model;
  const std::vector<int> held_out = PointsHeldOut(model);
  predicted.setConstant(3, static_cast<long>(model.problem->data().observations.size()), kNotKnown);
  predicted(Eigen::all, held_out) = PredictPoints(*model.problem, model.estimate.parameters, held_out);
  return model;
}

double HoldoutGain(const DiagnosedModel& before, const DiagnosedModel& after) {
  const Eigen::VectorXd gains = SumHoldout(before).squares - SumHoldout(after).squares;
  const double scatter = gains.norm();
  if (!(scatter > 0.0)) return 0.0;
  const double by_scatter = gains.sum() / scatter;
  if (by_scatter <= 0.0 || IsBeyondChance(by_scatter)) return by_scatter;
  return std::max(by_scatter, NormalQuantile(1.0 - ChanceBySigns(gains)));
}

bool IsBeyondChance(double gain) { return gain > NormalQuantile(1.0 - kBetterBeyondChance); }

bool MakesHoldoutWorse(const DiagnosedModel& before, const DiagnosedModel& after) {
  const HoldoutSums sums = SumHoldout(after);
  const int held_out = Count(sums);
  if (held_out < kFewHeldOut) return false;
  const Eigen::VectorXd &now = sums.squares, then = SumHoldout(before).squares;
  const double limit = NormalQuantile(1.0 - kWorseBeyondChance);
  if ((now - then).sum() > limit * (now - then).norm()) return true;
  // A few configurations that are far off say nothing by their own scatter. Root mean squares of n points scatter by
  // 1 / sqrt(6 n) of themselves, and two of the same points by less.
  const double growth = 1.0 + limit / std::sqrt(6.0 * static_cast<double>(held_out));
  return now.sum() > growth * growth * then.sum();
}

double FreedomOfHoldout(const DiagnosedModel& model) {
  const double apart = 3.0 * static_cast<double>(CountHeldOut(model));
  if (model.estimate.covariance.size() == 0) return apart;  // not judged
  const std::optional<PredictedSquares> predicted = PredictedOfHoldout(*model.problem, model.estimate);
  return predicted && predicted->trace > 0.0 ? std::min(apart, predicted->Freedom()) : apart;
}

double ChanceOfHoldout(const DiagnosedModel& model, bool is_sigma_stated) {
  const Estimate& estimate = model.estimate;
  const int held_out = CountHeldOut(model);
  if (held_out < kFewHeldOut || !(estimate.noise_floor > 0.0)) return kNotKnown;
  const double ratio = std::pow(estimate.validation.rms / estimate.noise_floor, 2);
  const double freedom = FreedomOfHoldout(model);
  const double of_noise = is_sigma_stated ? DofOfSizes(model.problem->repeat_scatter) : std::max(1, estimate.dof);
  return std::isinf(of_noise) ? ChiSquareSurvival(freedom * ratio, freedom) : FSurvival(ratio, freedom, of_noise);
}

bool IsFarFromFloor(const DiagnosedModel& model, bool is_sigma_stated, double significance) {
  return ChanceOfHoldout(model, is_sigma_stated) < kShareOfHoldout * significance;
}

// The interval: configurations drawn with replacement, 2.5 and 97.5 % of the draws (Efron and Tibshirani 1993,
// section 13.3).
GapReport JudgeGap(const DiagnosedModel& baseline, const DiagnosedModel& extended, double floor, bool is_noise_stated) {
  GapReport gap;
  gap.floor = floor;
  const HoldoutSums before = SumHoldout(baseline), after = SumHoldout(extended);
  std::vector<int> held_out;
  for (int c = 0; c < before.coordinates.size(); ++c) {
    if (before.coordinates[c] > 0.0) held_out.push_back(c);
  }
  const auto closed = [&](const std::vector<int>& picked) {
    const double b = SquaredGap(before, picked, floor);
    return b > 0.0 ? 1.0 - SquaredGap(after, picked, floor) / b : 0.0;
  };
  gap.before = std::sqrt(SquaredGap(before, held_out, floor));
  gap.after = std::sqrt(SquaredGap(after, held_out, floor));
  gap.closed = gap.before > 0.0 ? closed(held_out) : kNotKnown;
  gap.closed_ci95 = {kNotKnown, kNotKnown};
  if (is_noise_stated) gap.p = ChanceOfHoldout(extended, true);
  if (!is_noise_stated) gap.floor = kNotKnown;
  if (held_out.empty() || !is_noise_stated) gap.before = gap.after = gap.closed = kNotKnown;
  if (held_out.size() < kFewHeldOut || std::isnan(gap.closed)) return gap;
  std::mt19937_64 random(1);
  std::vector<double> draws;
  for (int d = 0; d < kBootstrapDraws; ++d) {
    std::vector<int> picked;
    for (size_t i = 0; i < held_out.size(); ++i) picked.push_back(held_out[random() % held_out.size()]);
    draws.push_back(closed(picked));
  }
  std::sort(draws.begin(), draws.end());
  gap.closed_ci95 = {draws[kBeyondAnEnd], draws[kBootstrapDraws - 1 - kBeyondAnEnd]};
  return gap;
}

}  // namespace sagitta
