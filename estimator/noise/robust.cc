#include "estimator/noise/robust.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/alignment/starting_values.h"
#include "estimator/statistics/distributions.h"
#include "models/matrix_functions.h"
#include "models/quantiles.h"
#include "models/row_block.h"

namespace sagitta {
namespace {

constexpr int kAlignRounds = 6;         // a guard: rows that are kept once more end them
constexpr double kFarFromMedian = 6.0;  // left out of the next alignment
constexpr double kFollows = 0.05;       // share of its own noise that a point still shows

// Distances of the listed observations to an aligned nominal robot, m; of a rotation that of its point.
std::vector<double> AlignedDistances(const CalibrationProblem& problem, const std::vector<int>& observations,
                                     const ParameterSet& parameters) {
  const Eigen::Matrix3Xd predicted = PredictPoints(problem, parameters, observations);
  std::map<int, double> of_row;  // by the observation that is the row's point
  std::vector<double> distances;
  for (const bool points : {true, false}) {
    distances.clear();
    for (size_t k = 0; k < observations.size(); ++k) {
      const Observation& row = problem.data().observations[observations[k]];
      if (points && row.is_point()) of_row[observations[k]] = (row.point_in_station - predicted.col(k)).norm();
      distances.push_back(of_row[row.is_point() ? observations[k] : row.partner]);
    }
  }
  return distances;
}

// Observations within reach of the median, but all of a marker or station that would lose every row.
std::vector<int> WithinReach(const CalibrationProblem& problem, const std::vector<int>& observations,
                             const std::vector<double>& distances) {
  const double limit = kFarFromMedian * Median(distances);
  const auto groups_of = [&](int i) {
    const Observation& observation = problem.data().observations[i];
    return std::make_pair(observation.marker, problem.data().shots[observation.shot].station);
  };
  std::map<int, int> left_of_marker, left_of_station;
  for (size_t k = 0; k < observations.size(); ++k) {
    const auto [marker, station] = groups_of(observations[k]);
    left_of_marker[marker] += distances[k] <= limit;
    left_of_station[station] += distances[k] <= limit;
  }
  std::vector<int> kept;
  for (size_t k = 0; k < observations.size(); ++k) {
    const auto [marker, station] = groups_of(observations[k]);
    const bool needed = left_of_marker[marker] < 2 || left_of_station[station] < 3;
    if (distances[k] <= limit || needed) kept.push_back(observations[k]);
  }
  return kept;
}

// One visit's share of a check: `rows` index points of `check`.
void CheckVisit(const Linearization& raw, const std::vector<double>& weights, double scale,
                const std::vector<int>& points, PointCheck* check) {
  const bool deviates = raw.latent.cols() > 0;
  // Where nothing deviates, one deviation that moves nothing: matrices have columns.
  const int n = 3 * static_cast<int>(points.size()), m = deviates ? static_cast<int>(raw.latent.cols()) : 1;
  Eigen::VectorXd residual(n), variance(n);  // u without deviations; 1 / w
  Eigen::MatrixXd latent = Eigen::MatrixXd::Zero(n, m);
  for (size_t i = 0; i < points.size(); ++i) {
    residual.segment<3>(3 * i) = -raw.residual.segment<3>(3 * points[i]) / scale;  // measured - predicted
    if (deviates) latent.middleRows<3>(3 * i) = raw.latent.middleRows<3>(3 * points[i]) / scale;
    variance.segment<3>(3 * i).setConstant(1.0 / std::max(1e-8, weights[points[i]]));
  }
  // delta = (I + L'WL)^-1 L'W r;  V^-1 = W - W L (I + L'WL)^-1 L'W
  const Eigen::MatrixXd weighted = variance.cwiseInverse().asDiagonal() * latent;
  const Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(m, m) + latent.transpose() * weighted;
  const Eigen::MatrixXd inverse = InverseOfPositive(inner);
  const Eigen::VectorXd pull = weighted.transpose() * residual, deviation = inverse * pull;
  const Eigen::VectorXd rest = residual - latent * deviation;
  // (I + L'L)^-1 L', without weights.
  const Eigen::MatrixXd squares = latent.transpose() * latent;
  const Eigen::MatrixXd plain = InverseOfPositive(Eigen::MatrixXd::Identity(m, m) + squares) * latent.transpose();
  for (size_t i = 0; i < points.size(); ++i) {
    const int k = points[i];
    // Leaving point i out (Sherman, Morrison and Woodbury): with e = (V^-1 r)_i and K = (V^-1)_ii, what the others
    // predict misses the reading by K^-1 e, with the covariance K^-1; its own variance 1 / w counts there, 1 when it is
    // judged.
    const double own = variance[3 * i];
    check->distance[k] = rest.segment<3>(3 * i).norm();
    // tr cov(u) / 3 = 1 - tr(L_i (1 + L'L)^-1 L_i') / 3 with all weights 1.
    check->expected[k] = 1.0 - (latent.middleRows<3>(3 * i) * plain.middleCols<3>(3 * i)).trace() / 3.0;
    const Eigen::MatrixXd row = weighted.middleRows<3>(3 * i);
    const Matrix3<double> precision = Matrix3<double>::Identity() / own - row * inverse * row.transpose();
    const Matrix3<double> spread = precision.inverse();
    const Vector3<double> error = spread * (rest.segment<3>(3 * i) / own);
    const Matrix3<double> predictive = spread + (1.0 - own) * Matrix3<double>::Identity();
    check->leave_one_out[k] = error.dot(predictive.inverse() * error);
    check->error.col(k) = scale * error;
  }
}

}  // namespace

double LossWeight(LossKind loss, double distance) {
  if (loss == LossKind::kHuber) return distance > kHuberTuning ? kHuberTuning / distance : 1.0;
  if (loss == LossKind::kCauchy) return 1.0 / (1.0 + distance * distance / (kCauchyTuning * kCauchyTuning));
  return 1.0;
}

double LossDerivative(LossKind loss, double distance) {
  if (loss == LossKind::kHuber) return distance > kHuberTuning ? 0.0 : 1.0;
  if (loss != LossKind::kCauchy) return 1.0;
  const double t = distance * distance / (kCauchyTuning * kCauchyTuning);
  return (1.0 - t) / ((1.0 + t) * (1.0 + t));
}

PointCheck CheckPoints(const CalibrationProblem& problem, const ParameterSet& parameters, const NoiseRoots& noise,
                       const std::vector<double>& weights, double scale) {
  PointCheck check;
  check.observations = problem.CalibrationObservations();
  const size_t n = check.observations.size();
  check.distance.resize(n);
  check.leave_one_out.resize(n);
  check.expected.resize(n);
  check.error.resize(3, n);
  const Linearization raw = Linearize(problem, parameters, check.observations, {}, noise, LatentTreatment::kIgnore);
  std::map<int, std::vector<int>> points_of_visit;
  for (size_t k = 0; k < n; ++k) {
    const int shot = problem.data().observations[check.observations[k]].shot;
    points_of_visit[problem.latent.visit_of_shot[shot]].push_back(static_cast<int>(k));
  }
  for (const auto& [visit, points] : points_of_visit) CheckVisit(raw, weights, scale, points, &check);
  for (size_t k = 0; k < n; ++k) check.error.col(k) = noise[k] * Vector3<double>(check.error.col(k));
  return check;
}

double RobustScale(const PointCheck& check) {
  std::vector<double> squared;
  for (size_t k = 0; k < check.distance.size(); ++k) {
    if (check.expected[k] > kFollows) squared.push_back(check.distance[k] * check.distance[k] / check.expected[k]);
  }
  return squared.empty() ? 1.0 : std::sqrt(Median(squared) / ChiSquareQuantile(0.5, 3.0));
}

double LossInflation(LossKind loss, const PointCheck& check, const std::vector<bool>& kept) {
  double score = 0.0, slope = 0.0, squares = 0.0, count = 0.0;
  for (size_t k = 0; k < check.distance.size(); ++k) {
    const double r = check.distance[k], w = LossWeight(loss, r);
    // psi = w r; per axis psi^2 / 3, and the mean slope over three axes, (psi' + 2 psi / r) / 3: one along the
    // residual, two across it.
    score += w * w * r * r / 3.0;
    slope += (LossDerivative(loss, r) + 2.0 * w) / 3.0;
    if (!kept[k]) continue;
    squares += r * r / 3.0;
    count += 1.0;
  }
  if (!(squares > 0.0 && slope > 0.0)) return 1.0;
  return (score / count) / std::pow(slope / count, 2) / (squares / count);
}

std::vector<double> AlignRobustly(const CalibrationProblem& problem, LossKind loss, ParameterSet* parameters) {
  const std::vector<int> all = problem.CalibrationObservations();
  const ParameterSet start = *parameters;
  std::vector<int> kept = all;
  std::vector<double> distances;
  for (int round = 0; round < kAlignRounds; ++round) {
    *parameters = start;
    FindStartingValues(problem, kept, parameters);
    distances = AlignedDistances(problem, all, *parameters);
    std::vector<int> next = WithinReach(problem, all, distances);
    if (next == kept) break;
    kept = std::move(next);
  }
  const double unit = std::max(1e-12, Median(distances) / std::sqrt(ChiSquareQuantile(0.5, 3.0)));
  std::vector<double> weights;
  for (const double distance : distances) weights.push_back(LossWeight(loss, distance / unit));
  return weights;
}

}  // namespace sagitta
