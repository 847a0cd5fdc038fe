#include "estimator/diagnosis/screening.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "estimator/statistics/distributions.h"

namespace sagitta {
namespace {

constexpr double kIndependent = 1e-5;  // projected norm over norm below which a column says nothing new
constexpr double kRankTolerance = 1e-6;
constexpr double kTwiceIsEnough = 0.5;  // norm that a direction keeps when projected again, below which it is rounding
constexpr double kTypicalPerHoldLimit = 0.1;  // TraitsOf: a direction is held beyond ten typical sizes

Eigen::MatrixXd OrthonormalBasis(const Eigen::MatrixXd& columns) {
  if (columns.cols() == 0) return columns;
  Eigen::MatrixXd scaled = columns;
  for (int c = 0; c < scaled.cols(); ++c) scaled.col(c) /= std::max(1e-300, scaled.col(c).norm());
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-10);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
}

}  // namespace

double CorrectedP(double reduction, int parameters, double scatter, int dof, int tests) {
  const double m = std::max(1, parameters);
  const bool is_known = scatter <= 1.0 || dof <= 0;
  const double p = is_known ? ChiSquareSurvival(reduction, m) : FSurvival(reduction / (m * scatter), m, dof);
  return std::min(1.0, tests * p);
}

NormalEquations ReduceOff(Eigen::MatrixXd information, const Eigen::Ref<const Eigen::MatrixXd>& on_believed,
                          Eigen::VectorXd gradient) {
  NormalEquations normal{std::move(information), std::move(gradient)};
  const Eigen::VectorXd squared = normal.information.diagonal();
  normal.information -= on_believed.transpose() * on_believed;
  for (int c = 0; c < squared.size(); ++c) {
    if (normal.information(c, c) > kIndependent * kIndependent * squared[c]) continue;
    normal.information.row(c).setZero();
    normal.information.col(c).setZero();
    normal.gradient[c] = 0.0;
  }
  return normal;
}

ProjectedResidual::ProjectedResidual(const Linearization& believed)
    : ProjectedResidual(believed.jacobian, believed.residual) {}

ProjectedResidual::ProjectedResidual(const Eigen::MatrixXd& believed, const Eigen::VectorXd& residual)
    : basis_(OrthonormalBasis(believed)), residual_(residual) {
  residual_ -= basis_ * (basis_.transpose() * residual_);
}

Eigen::MatrixXd ProjectedResidual::ProjectOff(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd rest = columns - basis_ * (basis_.transpose() * columns);
  for (int c = 0; c < columns.cols(); ++c) {
    if (rest.col(c).norm() < kIndependent * columns.col(c).norm()) rest.col(c).setZero();
  }
  return rest;
}

Eigen::VectorXd ProjectedResidual::Reproduce(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target) const {
  if (columns.cols() == 0) return Eigen::VectorXd::Zero(target.size());
  const Eigen::MatrixXd rest = ProjectOff(columns);
  return rest * rest.completeOrthogonalDecomposition().solve(target);
}

Eigen::MatrixXd ProjectedResidual::NewDirections(const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd once = OrthonormalBasis(ProjectOff(columns));
  const Eigen::MatrixXd twice = once - basis_ * (basis_.transpose() * once);
  std::vector<int> kept;
  for (int c = 0; c < twice.cols(); ++c) {
    if (twice.col(c).norm() > kTwiceIsEnough) kept.push_back(c);
  }
  return OrthonormalBasis(twice(Eigen::all, kept));
}

ProjectedResidual ProjectedResidual::With(const Eigen::MatrixXd& columns) const {
  if (columns.cols() == 0) return *this;
  ProjectedResidual result;
  const Eigen::MatrixXd extra = NewDirections(columns);
  result.basis_.resize(basis_.rows(), basis_.cols() + extra.cols());
  result.basis_ << basis_, extra;
  result.residual_ = residual_ - extra * (extra.transpose() * residual_);
  result.noise_ = noise_;
  return result;
}

ProjectedResidual ProjectedResidual::InNoise(double factor) const {
  ProjectedResidual result = *this;
  result.residual_ /= factor;
  result.noise_ *= factor;
  return result;
}

NormalEquations ProjectedResidual::Reduce(const Eigen::MatrixXd& columns) const {
  return ReduceBlock(columns, OnBelieved(columns));
}

NormalEquations ProjectedResidual::ReduceBlock(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                                               const Eigen::Ref<const Eigen::MatrixXd>& on_believed) const {
  return ReduceOff(columns.transpose() * columns, on_believed, columns.transpose() * residual_);
}

Score ProjectedResidual::Test(const Eigen::MatrixXd& columns, int settings) const {
  return ScoreOf(Reduce(columns), residual_.size(), settings);
}

Score ScoreOf(const NormalEquations& normal, long rows, int settings) {
  Score score;
  if (normal.gradient.size() == 0) return score;
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
  const double n = static_cast<double>(rows);
  score.penalised = score.reduction - score.rank * std::log(n) - 2.0 * std::log(static_cast<double>(settings));
  return score;
}

double ProjectedResidual::MarginalGain(const Eigen::MatrixXd& columns) const {
  return MarginalGainOf(Reduce(columns), residual_.size());
}

double MarginalGainOf(const NormalEquations& normal, long rows) {
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
  return best - std::log(static_cast<double>(rows));
}

Linearization LinearizeEstimate(const CalibrationProblem& problem, const ParameterSet& parameters,
                                LatentTreatment treatment) {
  const std::vector<int> observations = problem.CalibrationObservations();
  return Linearize(problem, parameters, observations, parameters.EstimatedCoordinates(),
                   ObservationNoise(problem, observations, kFallbackSigma), treatment);
}

CandidateColumns ColumnsOf(const CalibrationProblem& problem, const ParameterSet& parameters,
                           const std::vector<EffectSpec>& specs, LatentTreatment treatment) {
  std::set<std::string> known;
  for (const EffectSpec& own : problem.robot.effects) known.insert(own.Path());
  std::vector<EffectSpec> fresh;
  std::vector<bool> has_columns;
  for (const EffectSpec& spec : specs) {
    has_columns.push_back(spec.effect != "gravity_compensator" && known.insert(spec.Path()).second);
    if (has_columns.back()) fresh.push_back(spec);
  }
  CalibrationProblem extended = problem.WithEffects(fresh);
  extended.parameters.CopyByName(parameters);
  std::map<std::string, std::vector<int>> coordinates_of;  // by path
  for (int i = 0; i < extended.parameters.num_coordinates(); ++i) {
    const std::string& name = extended.parameters.coordinates()[i].name;
    if (parameters.FindCoordinate(name) < 0) coordinates_of[name.substr(0, name.rfind('/'))].push_back(i);
  }
  CandidateColumns candidates;
  std::vector<int> all;
  for (size_t c = 0; c < specs.size(); ++c) {
    candidates.first.push_back(static_cast<int>(all.size()));
    if (!has_columns[c]) continue;
    const std::vector<int>& own = coordinates_of[specs[c].Path()];
    all.insert(all.end(), own.begin(), own.end());
  }
  candidates.first.push_back(static_cast<int>(all.size()));
  const std::vector<int> observations = extended.CalibrationObservations();
  candidates.columns = Linearize(extended, extended.parameters, observations, all,
                                 ObservationNoise(extended, observations, kFallbackSigma), treatment)
                           .jacobian;
  candidates.typical.resize(all.size());
  for (size_t c = 0; c < all.size(); ++c) {
    const Coordinate& coordinate = extended.parameters.coordinates()[all[c]];
    const QuantityTraits& traits = TraitsOf(coordinate.quantity);
    candidates.columns.col(c) *= traits.si_per_unit;
    candidates.typical[c] = kTypicalPerHoldLimit * traits.hold_limit / traits.si_per_unit;
    candidates.names.push_back(coordinate.name);
  }
  return candidates;
}

std::vector<int> InformedColumns(const NormalEquations& normal, const Eigen::VectorXd& typical) {
  Eigen::MatrixXd information = typical.asDiagonal() * normal.information * typical.asDiagonal();
  information.diagonal().array() += 1e-9;  // what nothing tells: known to 3e4 typical sizes
  const Eigen::VectorXd gradient = typical.cwiseProduct(normal.gradient);
  std::vector<int> kept(typical.size());
  std::iota(kept.begin(), kept.end(), 0);
  while (!kept.empty()) {
    const Eigen::MatrixXd covariance = information(kept, kept).inverse();
    const Eigen::VectorXd value = covariance * gradient(kept);
    int worst = -1;
    for (size_t c = 0; c < kept.size(); ++c) {
      const double variance = covariance(c, c);
      const bool significant = value[c] * value[c] > 9.0 * variance;
      const bool sized = std::abs(value[c]) < kOversized || typical.size() == 1;
      if (variance < 1.0 || (significant && sized)) continue;
      if (worst < 0 || variance > covariance(worst, worst)) worst = static_cast<int>(c);
    }
    if (worst < 0) break;
    kept.erase(kept.begin() + worst);
  }
  return kept;
}

Eigen::MatrixXd JointDeviationColumns(const CalibrationProblem& problem, const ParameterSet& parameters,
                                      LatentTreatment treatment) {
  // Order 0: the cosine column is that of a constant joint deviation.
  std::vector<EffectSpec> specs;
  for (const Joint& joint : problem.robot.chain.joints)
    specs.push_back({"joint_harmonic", joint.name, {{"order", "0"}}, {}});
  const CandidateColumns joints = ColumnsOf(problem, parameters, specs, treatment);
  return joints.columns(Eigen::all, std::vector<int>(joints.first.begin(), joints.first.end() - 1));
}

}  // namespace sagitta
