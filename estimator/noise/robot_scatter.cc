#include "estimator/noise/robot_scatter.h"

#include <algorithm>
#include <cmath>

#include "estimator/least_squares/linearization.h"
#include "models/matrix_functions.h"
#include "problems/noise_model.h"

namespace sagitta {
namespace {

// Of the coordinates, what weights w leave with a say: (sum w)^2 / (n sum w^2), Kish's effective sample size (Kish
// 1965). At a quarter, weighing by what is not the noise doubles standard deviations.
constexpr double kFewHaveASay = 0.25;
constexpr int kMostScatterSteps = 200;      // a guard: kSettledVariance ends them
constexpr double kSettledVariance = 1e-10;  // relative, of tau^2

// Residuals along the axes of each row's stated covariance: there it is diagonal, and stays so with tau^2 added.
struct AlongAxes {
  std::vector<double> variance, square;  // m^2
};

template <typename RootOf>
AlongAxes Residuals(const CalibrationProblem& problem, const Estimate& estimate, const RootOf& root_of) {
  AlongAxes along;
  for (const int i : problem.data().PointsAmong(problem.CalibrationObservations())) {
    const Matrix3<double> root = root_of(i);
    const PrincipalAxes own = PrincipalAxesOf(root * root.transpose());
    const Eigen::Vector3d residual = problem.data().observations[i].point_in_station - estimate.predicted.col(i);
    const Eigen::Vector3d turned = own.axes.transpose() * residual;
    for (int axis = 0; axis < 3; ++axis) {
      along.variance.push_back(std::max(0.0, own.values[axis]));
      along.square.push_back(turned[axis] * turned[axis]);
    }
  }
  return along;
}

// Fixed point of the likelihood's zero: t = sum w^2 (r^2 - s) / sum w^2, w = 1 / (s + t), damped by staying positive.
double VarianceOfRobot(const AlongAxes& along) {
  double t = 0.0;
  for (const double square : along.square) t += square / along.square.size();
  for (int step = 0; step < kMostScatterSteps; ++step) {
    double sum = 0.0, weights = 0.0;
    for (size_t k = 0; k < along.square.size(); ++k) {
      const double w = 1.0 / (along.variance[k] + t);
      sum += w * w * (along.square[k] - along.variance[k]);
      weights += w * w;
    }
    const double next = std::max(0.0, sum / weights);
    const bool settled = std::abs(next - t) <= kSettledVariance * t;
    t = next;
    if (settled || t == 0.0) break;
  }
  return t;
}

}  // namespace

bool ScattersByRobot(const CalibrationProblem& problem, const Estimate& estimate) {
  const Experiment& experiment = problem.experiment();
  const bool is_free = experiment.noise.from == NoiseSpec::From::kDefault &&
                       experiment.method.weights == Weights::kSigma && experiment.method.loss == LossKind::kNone &&
                       problem.latent.empty() && problem.resolved_noise.empty();
  const SigmaReport& sigma = estimate.sigma;
  if (!is_free || !IsUsable(estimate.status) || !sigma.stated || !sigma.scaled) return false;
  if (sigma.a_posteriori * sigma.a_posteriori < kInstrumentIsNotTheNoise) return false;
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (const int i : problem.data().PointsAmong(problem.CalibrationObservations())) {
    const Matrix3<double> root = problem.SqrtCovariance(i);
    if (!IsStated(root)) return false;
    const Eigen::Array3d weights = PrincipalAxesOf(root * root.transpose()).values.array().inverse();
    sum += weights.sum();
    squares += weights.square().sum();
    count += 3.0;
  }
  return sum * sum < kFewHaveASay * count * squares;
}

RobotScatter FindRobotScatter(const CalibrationProblem& problem, const Estimate& estimate) {
  const double variance =
      VarianceOfRobot(Residuals(problem, estimate, [&](int i) { return problem.SqrtCovariance(i); }));
  RobotScatter scatter{std::sqrt(variance), {}};
  double stated = 0.0, both = 0.0;  // of the calibration points
  for (const int i : problem.data().PointsAmong(problem.CalibrationObservations())) {
    stated += problem.SqrtCovariance(i).squaredNorm();
    both += problem.SqrtCovariance(i).squaredNorm() + 3.0 * variance;
  }
  for (size_t i = 0; i < problem.data().observations.size(); ++i) {
    Matrix3<double> root = problem.SqrtCovariance(static_cast<int>(i));
    if (problem.data().observations[i].is_point() && IsStated(root)) {
      const Matrix3<double> covariance = root * root.transpose() + variance * Matrix3<double>::Identity();
      // Scaled to the mean variance that was stated: weights change, the unit of chi-square does not.
      root = std::sqrt(stated / both) * LowerRoot(covariance);
    }
    scatter.roots.push_back(root);
  }
  return scatter;
}

double ScatterBeyondStated(const CalibrationProblem& problem, const Estimate& estimate) {
  const SigmaReport& sigma = estimate.sigma;
  const std::vector<int> rows = problem.CalibrationObservations();
  const bool is_asked = IsUsable(estimate.status) && sigma.stated && sigma.scaled && problem.latent.empty() &&
                        problem.stated_noise_factor == 1.0 && problem.scaled_groups.empty() &&
                        estimate.noise_report.components.empty() && estimate.dof > 0 &&
                        problem.data().PointsAmong(rows).size() == rows.size();
  if (!is_asked || sigma.a_posteriori * sigma.a_posteriori < kInstrumentIsNotTheNoise) return 0.0;
  const auto stated = [&](int i) {
    const Observation& observation = problem.data().observations[i];
    return StatedRoot(problem.experiment(), problem.data(), observation, observation.point_in_station);
  };
  if (!std::all_of(rows.begin(), rows.end(), [&](int i) { return IsStated(stated(i)); })) return 0.0;
  return std::sqrt(VarianceOfRobot(Residuals(problem, estimate, stated)) * estimate.rows / estimate.dof);
}

}  // namespace sagitta
