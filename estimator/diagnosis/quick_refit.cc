#include "estimator/diagnosis/quick_refit.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/linearization.h"

namespace sagitta {
namespace {

constexpr double kFallbackSigma = 1e-3;  // m
constexpr int kMostSteps = 6;
constexpr double kSmallStep = 0.01;  // standard deviations: chi-square is then right to 1e-4

// Steps that cross a bound stop there; the coordinate then has no say.
std::vector<int> InteriorCoordinates(const ParameterSet& parameters) {
  std::vector<int> interior;
  for (const int i : parameters.EstimatedCoordinates()) {
    if (parameters.Value(i) > parameters.coordinates()[i].lower) interior.push_back(i);
  }
  return interior;
}

void StepWithinBounds(const Eigen::VectorXd& step, const std::vector<int>& columns, ParameterSet* parameters) {
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters->num_coordinates());
  for (size_t c = 0; c < columns.size(); ++c) {
    const Coordinate& coordinate = parameters->coordinates()[columns[c]];
    delta[columns[c]] = std::max(step[c], coordinate.lower - parameters->Value(columns[c]));
  }
  parameters->Plus(delta);
}

}  // namespace

QuickRefit RefitQuickly(const CalibrationProblem& problem, const ParameterSet& start) {
  QuickRefit refit;
  refit.parameters = start;
  const std::vector<int> observations = problem.CalibrationObservations();
  const NoiseRoots noise = ObservationNoise(problem, observations, kFallbackSigma);
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMostSteps; ++i) {
    const std::vector<int> columns = InteriorCoordinates(refit.parameters);
    Linearization here = Linearize(problem, refit.parameters, observations, columns, noise);
    if (!here.valid) return refit;
    AppendPriors(refit.parameters, &here);
    const double chi2 = here.residual.squaredNorm();
    if (chi2 > last * (1.0 + 1e-6) + 1e-6) return refit;  // not nearly linear
    last = chi2;
    const Eigen::VectorXd scale = here.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
    const Eigen::MatrixXd scaled = here.jacobian * scale.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> factor(scaled.transpose() * scaled);
    if (factor.info() != Eigen::Success) return refit;
    const Eigen::VectorXd gradient = scaled.transpose() * here.residual;
    const Eigen::VectorXd step = -factor.solve(gradient);
    const Eigen::MatrixXd root = factor.matrixL().solve(Eigen::MatrixXd::Identity(columns.size(), columns.size()));
    const Eigen::VectorXd sigmas = root.colwise().norm();
    StepWithinBounds(step.cwiseProduct(scale), columns, &refit.parameters);
    if ((step.array().abs() > kSmallStep * sigmas.array()).any()) continue;
    refit.converged = true;
    refit.chi2 = chi2 + gradient.dot(step);
    refit.rows = here.num_rows();
    refit.dof = here.num_rows() - static_cast<int>(columns.size());
    refit.sigmas.setZero(refit.parameters.num_coordinates());
    refit.sigmas(columns) = sigmas.cwiseProduct(scale);
    return refit;
  }
  return refit;
}

}  // namespace sagitta
