#include "estimator/noise/weighting.h"

#include <cmath>
#include <numeric>

#include "estimator/noise/residual_noise.h"

namespace sagitta {
namespace {

constexpr double kAlike = 1e-9;  // relative difference of roots

NoiseRoots AllRoots(const CalibrationProblem& problem) {
  std::vector<int> all(problem.data.observations.size());
  std::iota(all.begin(), all.end(), 0);
  return ObservationNoise(problem, all, kFallbackSigma);
}

double CommonSigma(const NoiseRoots& noise) {
  double squares = 0.0;
  for (const Matrix3<double>& root : noise) squares += root.squaredNorm();
  return std::sqrt(squares / (3.0 * noise.size()));
}

bool AllAlike(const NoiseRoots& noise) {
  const double sigma = CommonSigma(noise);
  for (const Matrix3<double>& root : noise) {
    if ((root - sigma * Matrix3<double>::Identity()).norm() > kAlike * sigma) return false;
  }
  return true;
}

}  // namespace

bool WeighsOtherwise(const CalibrationProblem& problem) {
  const Experiment& experiment = problem.experiment;
  const NoiseSpec::From from = experiment.noise.from;
  if (experiment.weights == "sigma") return false;
  if (from == NoiseSpec::From::kResiduals || from == NoiseSpec::From::kVarianceComponents) return false;
  if (experiment.weights == "eq14") return true;
  return problem.sigma_is_stated() && !AllAlike(AllRoots(problem));
}

bool WeighsByEq14(const Experiment& experiment) {
  return experiment.weights == "eq14" || experiment.noise.from == NoiseSpec::From::kResiduals;
}

NoiseRoots RootsOfWeights(const Experiment& experiment, const NoiseRoots& noise) {
  if (experiment.weights == "equal") {
    return NoiseRoots(noise.size(), CommonSigma(noise) * Matrix3<double>::Identity());
  }
  return Eq14Roots(noise, experiment.noise.sigma0, experiment.noise.lambda);
}

Eigen::MatrixXd CovarianceOfWeighted(const Linearization& fit, const LinearSolution& solution, const NoiseRoots& noise,
                                     const NoiseRoots& weights) {
  Eigen::MatrixXd half = fit.jacobian * solution.covariance;  // W J N^-1
  for (size_t k = 0; k < noise.size(); ++k) {
    const Matrix3<double> ratio = weights[k].inverse() * noise[k];  // W S
    half.middleRows<3>(3 * k) = (ratio.transpose() * half.middleRows<3>(3 * k)).eval();
  }
  return half.transpose() * half;
}

}  // namespace sagitta
