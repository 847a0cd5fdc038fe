#include "estimator/diagnosis/screening.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>

#include "estimator/distributions.h"

namespace sagitta {
namespace {

constexpr double kFallbackSigma = 1e-3;  // m
constexpr double kIndependent = 1e-5;    // projected norm over norm below which a column says nothing new
constexpr double kRankTolerance = 1e-6;

Eigen::MatrixXd OrthonormalBasis(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd scaled = columns;
  for (int c = 0; c < scaled.cols(); ++c) scaled.col(c) /= std::max(1e-300, scaled.col(c).norm());
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-10);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
}

}  // namespace

ProjectedResidual::ProjectedResidual(const Linearization& believed)
    : basis_(OrthonormalBasis(believed.jacobian)), residual_(believed.residual) {
  residual_ -= basis_ * (basis_.transpose() * residual_);
}

Eigen::MatrixXd ProjectedResidual::ProjectOff(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd rest = columns - basis_ * (basis_.transpose() * columns);
  for (int c = 0; c < columns.cols(); ++c) {
    if (rest.col(c).norm() < kIndependent * columns.col(c).norm()) rest.col(c).setZero();
  }
  return rest;
}

ProjectedResidual ProjectedResidual::With(const Eigen::MatrixXd& columns) const {
  ProjectedResidual result;
  const Eigen::MatrixXd extra = OrthonormalBasis(ProjectOff(columns));
  result.basis_.resize(basis_.rows(), basis_.cols() + extra.cols());
  result.basis_ << basis_, extra;
  result.residual_ = residual_ - extra * (extra.transpose() * residual_);
  return result;
}

Score ProjectedResidual::Test(const Eigen::MatrixXd& columns, int settings) const {
  Score score;
  Eigen::MatrixXd rest = ProjectOff(columns);
  for (int c = 0; c < rest.cols(); ++c) {
    const double norm = rest.col(c).norm();
    if (norm > 0.0) rest.col(c) /= norm;
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rest.transpose() * rest, Eigen::ComputeFullV);
  const Eigen::VectorXd projected = svd.matrixV().transpose() * (rest.transpose() * residual_);
  for (int i = 0; i < projected.size(); ++i) {
    const double squared = svd.singularValues()[i];
    if (squared < kRankTolerance) continue;
    score.reduction += projected[i] * projected[i] / squared;
    ++score.rank;
  }
  if (score.rank == 0) return score;
  score.p_value = ChiSquareSurvival(score.reduction, score.rank);
  const double n = static_cast<double>(residual_.size());
  score.penalised = score.reduction - score.rank * std::log(n) - 2.0 * std::log(static_cast<double>(settings));
  return score;
}

Linearization LinearizeEstimate(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const std::vector<int> observations = problem.CalibrationObservations();
  Linearization linearization = Linearize(problem, parameters, observations, parameters.EstimatedCoordinates(),
                                          ObservationSigmas(problem, observations, kFallbackSigma));
  return linearization;
}

Eigen::MatrixXd CandidateColumns(const CalibrationProblem& problem, const ParameterSet& parameters,
                                 const EffectSpec& spec) {
  CalibrationProblem extended = problem.WithEffect(spec);
  extended.parameters.CopyByName(parameters);
  std::vector<int> columns;
  for (int i = 0; i < extended.parameters.num_coordinates(); ++i) {
    if (extended.parameters.coordinates()[i].name.rfind(spec.Path() + "/", 0) == 0) columns.push_back(i);
  }
  const std::vector<int> observations = extended.CalibrationObservations();
  const Linearization linearization = Linearize(extended, extended.parameters, observations, columns,
                                                ObservationSigmas(extended, observations, kFallbackSigma));
  Eigen::MatrixXd scaled = linearization.jacobian;
  for (size_t c = 0; c < columns.size(); ++c) {
    scaled.col(c) *= TraitsOf(extended.parameters.coordinates()[columns[c]].quantity).si_per_unit;
  }
  return scaled;
}

}  // namespace sagitta
