#include "estimator/validation/unseen.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "estimator/statistics/distributions.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

constexpr size_t kWorst = 5;

}  // namespace

UnseenPoints MeasureUnseen(const CalibrationProblem& problem, const std::vector<int>& observations,
                           const Eigen::Matrix3Xd& errors) {
  UnseenPoints unseen;
  unseen.points = static_cast<int>(observations.size());
  if (observations.empty()) return unseen;
  std::vector<double> farthest(problem.data().configurations.size(), -1.0);  // of each configuration; below 0: not seen
  std::vector<double> squares(farthest.size(), 0.0);
  for (size_t k = 0; k < observations.size(); ++k) {
    const double distance = errors.col(static_cast<Eigen::Index>(k)).norm();
    unseen.distances.push_back(distance);
    const int c = problem.data().shots[problem.data().observations[observations[k]].shot].configuration;
    farthest[c] = std::max(farthest[c], distance);
    squares[c] += distance * distance;
  }
  unseen.pose_accuracy = MeasurePoseAccuracy(problem, observations, errors);
  unseen.distance_rms = std::sqrt(errors.squaredNorm() / unseen.points);
  unseen.rms = unseen.distance_rms / std::sqrt(3.0);
  std::vector<double> distances = unseen.distances;
  unseen.distance_p50 = NearestRank(0.5, &distances);
  unseen.distance_p95 = NearestRank(0.95, &distances);
  unseen.distance_max = *std::max_element(distances.begin(), distances.end());
  std::vector<int> order;
  for (size_t c = 0; c < farthest.size(); ++c) {
    if (farthest[c] < 0.0) continue;
    order.push_back(static_cast<int>(c));
    unseen.squares.push_back(squares[c]);
  }
  const auto shown = order.begin() + static_cast<long>(std::min(kWorst, order.size()));
  std::partial_sort(order.begin(), shown, order.end(), [&farthest](int a, int b) {
    return farthest[a] > farthest[b] || (farthest[a] == farthest[b] && a < b);
  });
  for (auto c = order.begin(); c != shown; ++c) {
    unseen.worst.push_back({problem.data().configurations[*c].id, farthest[*c]});
  }
  return unseen;
}

Gain CompareRms(const UnseenPoints& before, const UnseenPoints& after, double significance, double least) {
  Gain gain;
  const size_t n = after.squares.size();
  if (before.squares.size() != n || !(before.rms > 0.0 && after.rms > 0.0)) return gain;
  const auto sum = [](const std::vector<double>& all) { return std::accumulate(all.begin(), all.end(), 0.0); };
  const double b = sum(before.squares), a = sum(after.squares);
  gain.ratio = before.rms / after.rms;
  if (std::abs(gain.ratio - 1.0) <= least) {
    gain.compared = Compared::kAsGood;
    return gain;
  }
  if (n < 2) return gain;
  double squares = 0.0;
  for (size_t c = 0; c < n; ++c) squares += std::pow(before.squares[c] / b - after.squares[c] / a, 2);
  const double freedom = static_cast<double>(n) - 1.0;
  const double sigma = std::sqrt(static_cast<double>(n) / freedom * squares), moved = std::log(b / a);
  if (moved > StudentQuantile(kUpperOf95, freedom) * sigma) gain.compared = Compared::kBetter;
  const double own = std::log(1.0 - std::min(after.parameters_share, 1.0 - 1e-12));
  if (own - moved > StudentQuantile(1.0 - significance, freedom) * sigma) gain.compared = Compared::kWorse;
  return gain;
}

void ComparePrediction(const PredictedSquares& predicted, const Estimate& estimate, UnseenPoints* unseen,
                       double of_stated) {
  if (unseen->points == 0 || !(predicted.trace > 0.0) || !std::isfinite(predicted.trace)) return;
  unseen->predicted_rms = std::sqrt(predicted.trace / (3.0 * unseen->points));
  unseen->freedom = predicted.Freedom();
  unseen->parameters_share = 1.0 - predicted.of_noise / predicted.trace;
  const double ratio = 3.0 * unseen->points * unseen->rms * unseen->rms / predicted.trace;
  const bool noise_is_estimated = estimate.sigma.IsOfResiduals() || estimate.sigma.scaled;
  if (noise_is_estimated && estimate.dof < 1) return;
  const double of_noise = noise_is_estimated ? estimate.dof : of_stated;
  unseen->p_value = ChanceOf(predicted, ratio, of_noise);
  unseen->p_mostly_unknown = ChanceOf(predicted, ratio / (kMostlyUnknown * kMostlyUnknown), of_noise);
}

double TimesStated(const Estimate& estimate) {
  return estimate.sigma.stated && estimate.sigma.scaled ? estimate.sigma.a_posteriori : 1.0;
}

NoiseRoots InstrumentOf(const Estimate& estimate, const std::vector<int>& observations) {
  NoiseRoots roots;
  roots.reserve(observations.size());
  for (const int i : observations) roots.push_back(TimesStated(estimate) * estimate.noise[i]);
  return roots;
}

}  // namespace sagitta
