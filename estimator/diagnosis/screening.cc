#include "estimator/diagnosis/screening.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "estimator/distributions.h"

namespace sagitta {
namespace {

constexpr double kFallbackSigma = 1e-3;  // m
constexpr double kIndependent = 1e-5;    // projected norm over norm below which a column says nothing new
constexpr double kRankTolerance = 1e-6;
constexpr double kTypicalPerHoldLimit = 0.1;  // TraitsOf: a direction is held beyond ten typical sizes

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

Eigen::VectorXd ProjectedResidual::SquaredOff(const Eigen::MatrixXd& columns) const {
  return (columns.colwise().squaredNorm() - (basis_.transpose() * columns).colwise().squaredNorm()).transpose();
}

Eigen::VectorXd ProjectedResidual::Reproduce(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target) const {
  const Eigen::MatrixXd rest = ProjectOff(columns);
  return rest * rest.completeOrthogonalDecomposition().solve(target);
}

ProjectedResidual ProjectedResidual::With(const Eigen::MatrixXd& columns) const {
  ProjectedResidual result;
  const Eigen::MatrixXd extra = OrthonormalBasis(ProjectOff(columns));
  result.basis_.resize(basis_.rows(), basis_.cols() + extra.cols());
  result.basis_ << basis_, extra;
  result.residual_ = residual_ - extra * (extra.transpose() * residual_);
  return result;
}

NormalEquations ProjectedResidual::Reduce(const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd believed = basis_.transpose() * columns;
  NormalEquations normal{columns.transpose() * columns, columns.transpose() * residual_};
  const Eigen::VectorXd whole = normal.information.diagonal();
  normal.information -= believed.transpose() * believed;
  for (int c = 0; c < columns.cols(); ++c) {
    if (normal.information(c, c) > kIndependent * kIndependent * whole[c]) continue;
    normal.information.row(c).setZero();
    normal.information.col(c).setZero();
    normal.gradient[c] = 0.0;
  }
  return normal;
}

Score ProjectedResidual::Test(const Eigen::MatrixXd& columns, int settings) const {
  Score score;
  if (columns.cols() == 0) return score;
  const NormalEquations normal = Reduce(columns);
  const Eigen::VectorXd scale = (normal.information.diagonal().array() > 0.0)
                                    .select(normal.information.diagonal().array().max(1e-300).sqrt().inverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * normal.information *
                                                             scale.asDiagonal());
  const Eigen::VectorXd projected = eigen.eigenvectors().transpose() * scale.cwiseProduct(normal.gradient);
  for (int i = 0; i < projected.size(); ++i) {
    const double squared = eigen.eigenvalues()[i];
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

double ProjectedResidual::MarginalGain(const Eigen::MatrixXd& columns) const {
  const NormalEquations normal = Reduce(columns);
  const double scale = normal.information.trace();
  if (!(scale > 0.0)) return -1e300;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal.information / scale);
  const Eigen::VectorXd projected = eigen.eigenvectors().transpose() * normal.gradient / std::sqrt(scale);
  double best = 0.0;
  for (double tau = 1.0; tau < 3e4; tau *= 2.0) {
    double gain = 0.0;
    for (int i = 0; i < projected.size(); ++i) {
      const double squared = eigen.eigenvalues()[i];
      if (squared < 1e-12) continue;
      const double t = tau * tau * squared;
      gain += projected[i] * projected[i] / squared * t / (1.0 + t) - std::log1p(t);
    }
    best = std::max(best, gain);
  }
  return best - std::log(static_cast<double>(residual_.size()));
}

Linearization LinearizeEstimate(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const std::vector<int> observations = problem.CalibrationObservations();
  Linearization linearization = Linearize(problem, parameters, observations, parameters.EstimatedCoordinates(),
                                          ObservationNoise(problem, observations, kFallbackSigma));
  return linearization;
}

std::vector<CandidateColumns> ColumnsOf(const CalibrationProblem& problem, const ParameterSet& parameters,
                                        const std::vector<EffectSpec>& specs) {
  std::set<std::string> known;
  for (const EffectSpec& own : problem.robot.effects) known.insert(own.Path());
  std::vector<EffectSpec> fresh;
  for (const EffectSpec& spec : specs) {
    if (spec.effect != "gravity_compensator" && known.insert(spec.Path()).second) fresh.push_back(spec);
  }
  CalibrationProblem extended = problem.WithEffects(fresh);
  extended.parameters.CopyByName(parameters);
  std::map<std::string, std::vector<int>> columns_of;  // by path
  std::vector<int> all;
  for (int i = 0; i < extended.parameters.num_coordinates(); ++i) {
    const std::string& name = extended.parameters.coordinates()[i].name;
    if (parameters.FindCoordinate(name) >= 0) continue;
    columns_of[name.substr(0, name.rfind('/'))].push_back(static_cast<int>(all.size()));
    all.push_back(i);
  }
  const std::vector<int> observations = extended.CalibrationObservations();
  const Linearization linearization = Linearize(extended, extended.parameters, observations, all,
                                                ObservationNoise(extended, observations, kFallbackSigma));
  std::vector<CandidateColumns> candidates;
  for (const EffectSpec& spec : specs) {
    const std::vector<int> own = columns_of[spec.Path()];
    CandidateColumns candidate{linearization.jacobian(Eigen::all, own), {}, Eigen::VectorXd(own.size())};
    for (size_t c = 0; c < own.size(); ++c) {
      const Coordinate& coordinate = extended.parameters.coordinates()[all[own[c]]];
      const QuantityTraits& traits = TraitsOf(coordinate.quantity);
      candidate.columns.col(c) *= traits.si_per_unit;
      candidate.typical[c] = kTypicalPerHoldLimit * traits.hold_limit / traits.si_per_unit;
      candidate.names.push_back(coordinate.name);
    }
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

std::vector<std::string> DropUninformed(const ProjectedResidual& residual, CandidateColumns* candidate) {
  NormalEquations normal = residual.Reduce(candidate->columns * candidate->typical.asDiagonal());
  normal.information.diagonal().array() += 1e-9;  // what nothing tells: known to 3e4 typical sizes
  std::vector<int> kept(candidate->names.size());
  std::iota(kept.begin(), kept.end(), 0);
  std::vector<std::string> dropped;
  while (!kept.empty()) {
    const Eigen::MatrixXd covariance = normal.information(kept, kept).inverse();
    const Eigen::VectorXd value = covariance * normal.gradient(kept);
    int worst = -1;
    for (size_t c = 0; c < kept.size(); ++c) {
      const double variance = covariance(c, c);
      if (variance < 1.0 || value[c] * value[c] > 9.0 * variance) continue;
      if (worst < 0 || variance > covariance(worst, worst)) worst = static_cast<int>(c);
    }
    if (worst < 0) break;
    dropped.push_back(candidate->names[kept[worst]]);
    kept.erase(kept.begin() + worst);
  }
  if (dropped.empty()) return dropped;
  std::vector<std::string> names;
  for (const int c : kept) names.push_back(candidate->names[c]);
  candidate->columns = Eigen::MatrixXd(candidate->columns(Eigen::all, kept));
  candidate->typical = Eigen::VectorXd(candidate->typical(kept));
  candidate->names = std::move(names);
  return dropped;
}

Eigen::MatrixXd JointDeviationColumns(const CalibrationProblem& problem, const ParameterSet& parameters) {
  // Order 0: the cosine column is that of a constant joint deviation.
  std::vector<EffectSpec> specs;
  for (const Joint& joint : problem.robot.chain.joints)
    specs.push_back({"joint_harmonic", joint.name, {{"order", "0"}}, {}});
  const std::vector<CandidateColumns> joints = ColumnsOf(problem, parameters, specs);
  Eigen::MatrixXd deviations(joints[0].columns.rows(), specs.size());
  for (size_t j = 0; j < specs.size(); ++j) deviations.col(j) = joints[j].columns.col(0);
  return deviations;
}

}  // namespace sagitta
