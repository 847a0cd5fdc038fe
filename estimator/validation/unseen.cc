#include "estimator/validation/unseen.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/least_squares/row_sums.h"
#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

constexpr size_t kWorst = 5;

// Nearest rank: the smallest value that is not exceeded by the share p.
double Quantile(const std::vector<double>& sorted, double p) {
  const auto rank = static_cast<size_t>(std::ceil(p * sorted.size()));
  return sorted[std::clamp<size_t>(rank, 1, sorted.size()) - 1];
}

}  // namespace

UnseenPoints MeasureUnseen(const CalibrationProblem& problem, const std::vector<int>& observations,
                           const Eigen::Matrix3Xd& errors) {
  UnseenPoints unseen;
  unseen.points = static_cast<int>(observations.size());
  if (observations.empty()) return unseen;
  std::map<int, double> farthest;  // of each configuration
  for (size_t k = 0; k < observations.size(); ++k) {
    const double distance = errors.col(static_cast<Eigen::Index>(k)).norm();
    unseen.distances.push_back(distance);
    double& own = farthest[problem.data.shots[problem.data.observations[observations[k]].shot].configuration];
    own = std::max(own, distance);
  }
  unseen.pose_accuracy = MeasurePoseAccuracy(problem, observations, errors);
  unseen.distance_rms = std::sqrt(errors.squaredNorm() / unseen.points);
  unseen.rms = unseen.distance_rms / std::sqrt(3.0);
  std::vector<double> sorted = unseen.distances;
  std::sort(sorted.begin(), sorted.end());
  unseen.distance_p50 = Quantile(sorted, 0.5);
  unseen.distance_p95 = Quantile(sorted, 0.95);
  unseen.distance_max = sorted.back();
  for (const auto& [configuration, distance] : farthest)
    unseen.worst.push_back({problem.data.configurations[configuration].id, distance});
  std::stable_sort(unseen.worst.begin(), unseen.worst.end(),
                   [](const FarPose& a, const FarPose& b) { return a.distance > b.distance; });
  if (unseen.worst.size() > kWorst) unseen.worst.resize(kWorst);
  return unseen;
}

void PredictedSquares::Add(const NoiseRoots& noise, const Eigen::MatrixXd& jacobian, const Eigen::MatrixXd& root) {
  Linearization moved;  // J R
  moved.jacobian = TallProduct(jacobian, root);
  moved.residual.setZero(moved.jacobian.rows());
  for (size_t k = 0; k < noise.size(); ++k) {
    const Matrix3<double> own = noise[k] * noise[k].transpose();
    const auto rows = moved.jacobian.middleRows<3>(3 * static_cast<Eigen::Index>(k));
    const Matrix3<double> by_parameters = rows * rows.transpose();
    trace += own.trace() + by_parameters.trace();
    trace_of_square += own.squaredNorm() + 2.0 * own.cwiseProduct(by_parameters).sum();
  }
  // tr (J C J')^2 = |(J R)' J R|^2
  trace_of_square += SumRows(moved).matrix.squaredNorm();
}

void ComparePrediction(const PredictedSquares& predicted, const Estimate& estimate, UnseenPoints* unseen) {
  if (unseen->points == 0 || !(predicted.trace > 0.0) || !std::isfinite(predicted.trace)) return;
  unseen->predicted_rms = std::sqrt(predicted.trace / (3.0 * unseen->points));
  const double freedom = predicted.trace * predicted.trace / predicted.trace_of_square;
  const double ratio = 3.0 * unseen->points * unseen->rms * unseen->rms / predicted.trace;
  const bool noise_is_estimated = !estimate.sigma.stated || estimate.sigma.scaled;
  if (noise_is_estimated && estimate.dof < 1) return;
  unseen->p_value =
      noise_is_estimated ? FSurvival(ratio, freedom, estimate.dof) : ChiSquareSurvival(ratio * freedom, freedom);
}

NoiseRoots ScatterOf(const Estimate& estimate, const std::vector<int>& observations) {
  const double scale = estimate.sigma.stated && estimate.sigma.scaled ? estimate.sigma.a_posteriori : 1.0;
  NoiseRoots roots;
  for (const int i : observations) roots.push_back(scale * estimate.scatter[i]);
  return roots;
}

}  // namespace sagitta
