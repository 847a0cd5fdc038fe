#include "estimator/noise/weighting.h"

#include <cmath>

#include "estimator/least_squares/normal_equations.h"
#include "estimator/noise/residual_noise.h"

namespace sagitta {
namespace {

constexpr double kEqualRoots = 1e-9;  // relative difference of roots

double RmsSigma(const NoiseRoots& noise) {
  double squares = 0.0;
  for (const Matrix3<double>& root : noise) squares += root.squaredNorm();
  return std::sqrt(squares / (3.0 * noise.size()));
}

bool AllAlike(const NoiseRoots& noise) {
  const double sigma = RmsSigma(noise);
  for (const Matrix3<double>& root : noise) {
    if ((root - sigma * Matrix3<double>::Identity()).norm() > kEqualRoots * sigma) return false;
  }
  return true;
}

}  // namespace

namespace {

// noise_of: of the rows in question.
template <typename NoiseOf>
bool WeighsOtherwiseThan(const CalibrationProblem& problem, const NoiseOf& noise_of) {
  const Experiment& experiment = problem.experiment();
  const NoiseSpec::From from = experiment.noise.from;
  if (experiment.method.weights == Weights::kSigma) return false;
  if (from == NoiseSpec::From::kResiduals || from == NoiseSpec::From::kVarianceComponents) return false;
  if (experiment.method.weights == Weights::kEq14) return true;
  return problem.sigma_is_stated() && !AllAlike(noise_of());
}

}  // namespace

bool WeighsOtherwise(const CalibrationProblem& problem) {
  return WeighsOtherwiseThan(problem, [&] { return NoiseOfAll(problem, kFallbackSigma); });
}

bool WeighsOtherwise(const CalibrationProblem& problem, const std::vector<int>& observations) {
  return WeighsOtherwiseThan(problem, [&] { return ObservationNoise(problem, observations, kFallbackSigma); });
}

bool WeighsByEq14(const Experiment& experiment) {
  return experiment.method.weights == Weights::kEq14 || experiment.noise.from == NoiseSpec::From::kResiduals;
}

NoiseRoots RootsOfWeights(const Experiment& experiment, const NoiseRoots& noise) {
  if (experiment.method.weights == Weights::kEqual) {
    return NoiseRoots(noise.size(), RmsSigma(noise) * Matrix3<double>::Identity());
  }
  return Eq14Roots(noise, experiment.noise.sigma0, experiment.noise.lambda);
}

// N^-1 (sum J'W W S S'W W J) N^-1, from rows W J, whitened by the weights; S the root of the noise.
Eigen::MatrixXd CovarianceOfWeighted(const CalibrationProblem& problem, const ParameterSet& parameters,
                                     const LinearSolution& solution) {
  const std::vector<int> columns = parameters.EstimatedCoordinates();
  const std::vector<int> observations = problem.CalibrationObservations();
  const auto weights = [&problem](const std::vector<int>& listed) { return FitRoots(problem, listed, kFallbackSigma); };
  const auto n = static_cast<Eigen::Index>(columns.size());
  SumOfRows sums(static_cast<int>(n));
  RowMajorMatrix scattered(3, n);
  const RowStream stream(problem, observations, weights, LatentTreatment::kMarginalise);
  stream.ForEach(parameters, columns, [&](const RowPiece& piece) {
    std::vector<int> listed;
    for (const int k : piece.positions) listed.push_back(observations[k]);
    const NoiseRoots weight = weights(listed), noise = ObservationNoise(problem, listed, kFallbackSigma);
    for (int i = 0; i < piece.num_observations(); ++i) {
      const Matrix3<double> ratio = weight[i].inverse() * noise[i];  // W S
      scattered = ratio.transpose() * piece.rows.block(3 * i, 0, 3, n);
      for (int axis = 0; axis < 3; ++axis) sums.Add(scattered.row(axis).data());
    }
  });
  const Eigen::MatrixXd priors = PriorsOf(parameters, columns).jacobian;
  return solution.covariance * (sums.Total() + priors.transpose() * priors) * solution.covariance;
}

}  // namespace sagitta
