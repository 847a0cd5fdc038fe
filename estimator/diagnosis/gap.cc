#include "estimator/diagnosis/gap.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "models/constants.h"

namespace sagitta {
namespace {

constexpr int kBootstrapDraws = 400;
constexpr size_t kFewestResampled = 3;

// Squared hold-out residuals per configuration, m^2, and how many coordinates.
std::vector<std::pair<double, int>> HoldoutByConfiguration(const DiagnosedModel& model) {
  std::vector<std::pair<double, int>> sums(model.problem->data().configurations.size(), {0.0, 0});
  for (const int i : model.problem->data().PointsAmong(model.problem->ValidationObservations())) {
    const Observation& observation = model.problem->data().observations[i];
    auto& sum = sums[model.problem->data().shots[observation.shot].configuration];
    sum.first += (observation.point_in_station - model.estimate.predicted.col(i)).squaredNorm();
    sum.second += 3;
  }
  return sums;
}

// max(0, sum |r|^2 / n - floor^2), n coordinates.
double SquaredGap(const std::vector<std::pair<double, int>>& sums, const std::vector<int>& picked, double floor) {
  double sum = 0.0;
  int count = 0;
  for (const int i : picked) {
    sum += sums[i].first;
    count += sums[i].second;
  }
  return count > 0 ? std::max(0.0, sum / count - floor * floor) : 0.0;
}

}  // namespace

double HoldoutRms(const DiagnosedModel& model) {
  const Eigen::Matrix3Xd misfit = HoldoutMisfit(model);
  return std::sqrt(misfit.squaredNorm() / static_cast<double>(misfit.size()));
}

// The interval: configurations drawn with replacement, 2.5 and 97.5 % of the draws (Efron and Tibshirani 1993,
// section 13.3).
GapReport JudgeGap(const DiagnosedModel& baseline, const DiagnosedModel& extended, bool is_noise_stated) {
  GapReport gap;
  const auto before = HoldoutByConfiguration(baseline);
  const auto after = HoldoutByConfiguration(extended);
  const double floor = extended.estimate.noise_floor;
  std::vector<int> held_out;
  for (size_t c = 0; c < before.size(); ++c) {
    if (before[c].second > 0) held_out.push_back(static_cast<int>(c));
  }
  const auto closed = [&](const std::vector<int>& picked) {
    const double b = SquaredGap(before, picked, floor);
    return b > 0.0 ? 1.0 - SquaredGap(after, picked, floor) / b : 0.0;
  };
  gap.before = std::sqrt(SquaredGap(before, held_out, floor));
  gap.after = std::sqrt(SquaredGap(after, held_out, floor));
  gap.closed = closed(held_out);
  gap.closed_ci95 = {kNotKnown, kNotKnown};
  if (held_out.empty()) gap.before = gap.after = gap.closed = kNotKnown;
  if (!is_noise_stated) gap.closed = kNotKnown;
  if (held_out.size() < kFewestResampled || !is_noise_stated) return gap;
  std::mt19937_64 random(1);
  std::vector<double> draws;
  for (int d = 0; d < kBootstrapDraws; ++d) {
    std::vector<int> picked;
    for (size_t i = 0; i < held_out.size(); ++i) picked.push_back(held_out[random() % held_out.size()]);
    draws.push_back(closed(picked));
  }
  std::sort(draws.begin(), draws.end());
  gap.closed_ci95 = {draws[kBootstrapDraws / 40], draws[kBootstrapDraws - 1 - kBootstrapDraws / 40]};
  return gap;
}

}  // namespace sagitta
