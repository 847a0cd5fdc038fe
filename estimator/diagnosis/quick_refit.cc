#include "estimator/diagnosis/quick_refit.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/least_squares/linearization.h"

namespace sagitta {
namespace {

constexpr int kMostSteps = 40;  // most need two or three
constexpr double kFirstDamping = 1e-4;
constexpr double kSmallStep = 0.01;  // standard deviations
constexpr double kSmallGain = 1e-3;  // of chi-square: what the step promises; 0.03 standard deviations in all

// Steps that cross a bound stop there; the coordinate then has no say.
std::vector<int> InteriorCoordinates(const ParameterSet& parameters) {
  std::vector<int> interior;
  for (const int i : parameters.EstimatedCoordinates()) {
    if (parameters.Value(i) > parameters.coordinates()[i].lower) interior.push_back(i);
  }
  return interior;
}

// The step of every coordinate.
Eigen::VectorXd WithinBounds(const Eigen::VectorXd& step, const std::vector<int>& columns,
                             const ParameterSet& parameters) {
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters.num_coordinates());
  for (size_t c = 0; c < columns.size(); ++c) {
    const Coordinate& coordinate = parameters.coordinates()[columns[c]];
    delta[columns[c]] = std::max(step[c], coordinate.lower - parameters.Value(columns[c]));
  }
  return delta;
}

// Gauss-Newton at one point, columns scaled to unit norm.
struct LocalModel {
  std::vector<int> columns;
  Eigen::VectorXd scale, gradient;
  Eigen::MatrixXd information;
  double chi2 = 0.0;
  int rows = 0;
  bool valid = false;
};

LocalModel ModelAt(const CalibrationProblem& problem, const ParameterSet& parameters,
                   const std::vector<int>& observations, const NoiseRoots& noise) {
  LocalModel model;
  model.columns = InteriorCoordinates(parameters);
  Linearization here = Linearize(problem, parameters, observations, model.columns, noise);
  model.valid = here.valid;
  if (!here.valid) return model;
  AppendPriors(parameters, &here);
  model.rows = here.num_rows();
  model.chi2 = here.residual.squaredNorm();
  model.scale = here.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd scaled = here.jacobian * model.scale.asDiagonal();
  model.information = scaled.transpose() * scaled;
  model.gradient = scaled.transpose() * here.residual;
  return model;
}

}  // namespace

QuickRefit RefitQuickly(const CalibrationProblem& problem, const ParameterSet& start) {
  QuickRefit refit;
  refit.parameters = start;
  const std::vector<int> observations = problem.CalibrationObservations();
  const NoiseRoots noise = ObservationNoise(problem, observations, kFallbackSigma);
  LocalModel model = ModelAt(problem, start, observations, noise);
  double damping = 0.0;
  for (int i = 0; i < kMostSteps && model.valid; ++i) {
    const auto unknowns = static_cast<int>(model.columns.size());
    const Eigen::LLT<Eigen::MatrixXd> factor(model.information);
    if (factor.info() != Eigen::Success) return refit;
    const Eigen::VectorXd step = -factor.solve(model.gradient);
    const Eigen::VectorXd sigmas =
        Eigen::MatrixXd(factor.matrixL().solve(Eigen::MatrixXd::Identity(unknowns, unknowns))).colwise().norm();
    const double promised = -model.gradient.dot(step);
    if (promised <= kSmallGain || (step.array().abs() <= kSmallStep * sigmas.array()).all()) {
      refit.parameters.Plus(WithinBounds(step.cwiseProduct(model.scale), model.columns, refit.parameters));
      refit.converged = true;
      refit.chi2 = model.chi2 - promised;
      refit.rows = model.rows;
      refit.dof = model.rows - unknowns;
      refit.sigmas.setZero(refit.parameters.num_coordinates());
      refit.sigmas(model.columns) = sigmas.cwiseProduct(model.scale);
      return refit;
    }
    Eigen::MatrixXd damped = model.information;
    damped.diagonal().array() += damping;
    ParameterSet trial = refit.parameters;
    trial.Plus(WithinBounds(-damped.llt().solve(model.gradient).cwiseProduct(model.scale), model.columns, trial));
    LocalModel there = ModelAt(problem, trial, observations, noise);
    if (!there.valid || there.chi2 > model.chi2 * (1.0 + 1e-6) + 1e-6) {
      damping = std::max(kFirstDamping, 10.0 * damping);
      continue;
    }
    damping = damping > kFirstDamping ? 0.1 * damping : 0.0;
    refit.parameters = std::move(trial);
    model = std::move(there);
  }
  return refit;
}

}  // namespace sagitta
