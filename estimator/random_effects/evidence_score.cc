#include "estimator/random_effects/evidence_score.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimator/statistics/distributions.h"

namespace sagitta {

namespace {

constexpr int kFew = 16;  // columns of most groups: their root stays on the stack
using MatrixOfFew = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kFew, kFew>;

template <typename Matrix>
GroupGain GainBy(const Eigen::Ref<const Eigen::MatrixXd>& information,
                 const Eigen::Ref<const Eigen::VectorXd>& gradient, double variance) {
  Matrix posterior = variance * information;
  posterior.diagonal().array() += 1.0;
  const Eigen::LLT<Matrix> root(posterior);
  if (root.info() != Eigen::Success) return {};
  const Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1, Eigen::ColMajor, Matrix::MaxRowsAtCompileTime> rotated =
      root.matrixL().solve(gradient);
  return {variance * rotated.squaredNorm(), 2.0 * root.matrixLLT().diagonal().array().log().sum()};
}

// s^2 |L^-1 g|^2 of each gradient.
template <typename Matrix>
Eigen::VectorXd MostQuadsBy(const Eigen::MatrixXd& information, const Eigen::MatrixXd& gradients, double variance) {
  Matrix posterior = variance * information;
  posterior.diagonal().array() += 1.0;
  const Eigen::LLT<Matrix> root(posterior);
  if (root.info() != Eigen::Success) {
    return Eigen::VectorXd::Constant(gradients.cols(), std::numeric_limits<double>::infinity());
  }
  return variance * root.matrixL().solve(gradients).colwise().squaredNorm().transpose();
}

}  // namespace

// L L' = I + s^2 G:  quad = s^2 |L^-1 g|^2,  log det = 2 sum log L_ii; of one column  s^2 g^2 / t,  log t,  t = 1 + s^2
// G.
GroupGain GainOf(const Eigen::Ref<const Eigen::MatrixXd>& information,
                 const Eigen::Ref<const Eigen::VectorXd>& gradient, double scale) {
  const double variance = scale * scale;
  if (gradient.size() == 1) {
    const double t = 1.0 + variance * std::max(0.0, information(0, 0));
    return {variance * gradient[0] * gradient[0] / t, std::log(t)};
  }
  if (gradient.size() == 2) return GainBy<Eigen::Matrix2d>(information, gradient, variance);  // waves, most groups
  if (gradient.size() <= kFew) return GainBy<MatrixOfFew>(information, gradient, variance);
  return GainBy<Eigen::MatrixXd>(information, gradient, variance);
}

Eigen::VectorXd MostQuads(const Eigen::MatrixXd& least_information, const Eigen::MatrixXd& gradients) {
  const double variance = kWidestScale * kWidestScale;
  if (gradients.rows() == 1) {
    return variance / (1.0 + variance * std::max(0.0, least_information(0, 0))) * gradients.row(0).cwiseAbs2();
  }
  if (gradients.rows() <= kFew) return MostQuadsBy<MatrixOfFew>(least_information, gradients, variance);
  return MostQuadsBy<Eigen::MatrixXd>(least_information, gradients, variance);
}

// log sum exp(x) = m + log sum exp(x - m), m the largest.
double LogSumExp(const std::vector<double>& logs) {
  const double largest = *std::max_element(logs.begin(), logs.end());
  if (!std::isfinite(largest)) return largest;
  double sum = 0.0;
  for (const double value : logs) sum += std::exp(value - largest);
  return largest + std::log(sum);
}

double LogMean(const std::vector<double>& logs) { return LogSumExp(logs) - std::log(static_cast<double>(logs.size())); }

ResidualLikelihood::ResidualLikelihood(double dof, double sigma_dof, double wrong)
    : dof_(std::max(1.0, dof)), sigma_dof_(sigma_dof), wrong_(sigma_dof > 0.0 ? wrong : 1.0) {
  const double nu = sigma_dof_;
  open_constant_ = std::lgamma(0.5 * dof_) - std::log(2.0);
  stated_constant_ = std::isinf(nu) || !(nu > 0.0)
                         ? 0.0
                         : std::lgamma(0.5 * (nu + dof_)) - std::lgamma(0.5 * nu) + 0.5 * nu * std::log(0.5 * nu);
}

// Known, or 1/f^2 ~ Gamma(nu/2, nu/2): Student.
double ResidualLikelihood::LogStated(double residual) const {
  if (std::isinf(sigma_dof_)) return -0.5 * residual;
  return stated_constant_ - 0.5 * (sigma_dof_ + dof_) * std::log(0.5 * (sigma_dof_ + residual));
}

// log f even between -log F and log F:  1 / (2 log F) times the integral of f^-n exp(-R / 2 f^2) dlog f, with
// u = R / 2 f^2 an incomplete gamma function; the mean over both F. Nothing stated: the limit of large F without its
// constant.
double ResidualLikelihood::LogOpen(double residual) const {
  const double whole = open_constant_ - 0.5 * dof_ * std::log(0.5 * residual);
  if (!(sigma_dof_ > 0.0)) return whole;
  std::vector<double> densities;
  for (const double factor : {kUsualFactor, kWidestFactor}) {
    const double square = factor * factor;
    const double log_within = LogChiSquareBetween(residual / square, residual * square, dof_);
    densities.push_back(log_within - std::log(2.0 * std::log(factor)));
  }
  return whole + LogMean(densities);
}

// f(R) = (1 - wrong) f_stated(R) + wrong f_open(R).
double ResidualLikelihood::Log(double residual) const {
  const double positive = std::max(1e-12, residual);
  if (wrong_ >= 1.0) return LogOpen(positive);
  return LogSumExp({std::log(1.0 - wrong_) + LogStated(positive), std::log(wrong_) + LogOpen(positive)});
}

// Bayes: wrong f_open(R) / f(R).
double ResidualLikelihood::ProbabilityWrong(double residual) const {
  if (wrong_ >= 1.0) return 0.0;
  return std::exp(std::log(wrong_) + LogOpen(std::max(1e-12, residual)) - Log(residual));
}

double ResidualLikelihood::ChanceOf(double residual) const {
  if (!(sigma_dof_ > 0.0)) return 1.0;
  return std::isinf(sigma_dof_) ? ChiSquareSurvival(residual, dof_) : FSurvival(residual / dof_, dof_, sigma_dof_);
}

// Known or not stated: R / n. Stated with nu degrees of freedom: pooled, (nu + R) / (nu + n).
double ResidualLikelihood::Factor(double residual) const {
  if (std::isinf(sigma_dof_) || !(sigma_dof_ > 0.0)) return std::sqrt(residual / dof_);
  return std::sqrt((sigma_dof_ + residual) / (sigma_dof_ + dof_));
}

// Open: sigma^2 has the scaled inverse chi-square distribution of R and n degrees of freedom; stated with nu: of
// nu + R and nu + n.
double ResidualLikelihood::LogPositive(double z, double residual) const {
  const double positive = std::max(1e-12, residual);
  const double as_open = LogStudentCdf(z / std::sqrt(positive / dof_), dof_);
  if (wrong_ >= 1.0) return as_open;
  const double as_stated =
      std::isinf(sigma_dof_) ? LogNormalCdf(z) : LogStudentCdf(z / Factor(positive), sigma_dof_ + dof_);
  const double wrong = ProbabilityWrong(positive);
  return LogSumExp({std::log(1.0 - wrong) + as_stated, std::log(wrong) + as_open});
}

// log L(s) = log f(R - quad(s)) - 1/2 (log |Q| + log |I + s^2 G|), R, Q, G given the others.
std::vector<double> LogsOfScales(const ResidualLikelihood& likelihood, const GivenOthers& given) {
  std::vector<double> logs;
  for (int s = 0; s < given.num_scales; ++s) {
    const GroupGain gain = GainOf(given.information, given.gradient, kScales[s]);
    logs.push_back(likelihood.Log(given.residual - gain.quad) - 0.5 * (given.log_det + gain.log_det));
  }
  return logs;
}

double LossOfScale(const ResidualLikelihood& likelihood, const GivenOthers& given) {
  const std::vector<double> logs = LogsOfScales(likelihood, given);
  return LogMean(logs) - *std::max_element(logs.begin(), logs.end());
}

// P(a > 0) = 1/2 before the rows. In units of s: a / s = -s (I + s^2 G)^-1 g, its covariance (I + s^2 G)^-1.
double LogOfSigns(const ResidualLikelihood& likelihood, const GivenOthers& given, double scale) {
  if (given.not_negative.empty()) return 0.0;
  Eigen::MatrixXd posterior = scale * scale * given.information;
  posterior.diagonal().array() += 1.0;
  const Eigen::MatrixXd covariance =
      posterior.llt().solve(Eigen::MatrixXd::Identity(posterior.rows(), posterior.cols()));
  const Eigen::VectorXd values = -scale * (covariance * given.gradient);
  const double residual = given.residual + given.gradient.dot(scale * values);
  double sum = 0.0;
  for (const int c : given.not_negative)
    sum += std::log(2.0) + likelihood.LogPositive(values[c] / std::sqrt(covariance(c, c)), residual);
  return sum;
}

double MostOfSigns(const std::vector<int>& not_negative) {
  return std::log(2.0) * static_cast<double>(not_negative.size());
}

// log B = log mean_s B(s).
double AverageGain(const ResidualLikelihood& likelihood, const GivenOthers& given, double* scale) {
  const std::vector<double> logs = LogsOfScales(likelihood, given);
  const double best = kScales[std::max_element(logs.begin(), logs.end()) - logs.begin()];
  if (scale != nullptr) *scale = best;
  return LogMean(logs) - likelihood.Log(given.residual) + 0.5 * given.log_det + LogOfSigns(likelihood, given, best);
}

}  // namespace sagitta
