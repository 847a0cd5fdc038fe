#include "estimator/noise/variance_components.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "estimator/statistics/distributions.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

constexpr double kReference = 1e-5;  // rad or m: deviations are counted in these
constexpr int kMaxNewton = 100;
constexpr int kMaxHalvings = 30;
constexpr int kMostWidenings = 40;
constexpr double kSmallestInstrument = 1e-8;  // variance factor
constexpr double kConverged = 1e-9;           // of the deviance

// Every joint deviates by the reference.
CalibrationProblem WithReferenceDeviations(CalibrationProblem problem) {
  LatentModel& latent = problem.latent;
  latent.joints.resize(problem.robot().num_joints());
  std::iota(latent.joints.begin(), latent.joints.end(), 0);
  latent.sigmas = Eigen::VectorXd::Constant(problem.robot().num_joints(), kReference);
  return problem;
}

// Where nothing is estimated one parameter stands in that no reading knows, with a prior of zero and one: it adds
// ln 1 = 0 to the likelihood, and no matrix is without columns.
void StandIn(Linearization* all) {
  all->jacobian = Eigen::MatrixXd::Zero(all->num_rows() + 1, 1);
  all->jacobian.bottomRows(1).setOnes();
  all->residual.conservativeResize(all->num_rows() + 1);
  all->residual.tail(1).setZero();
}

// Root of an increasing function between `inside`, where it is negative, and `outside`, where it is `there`
// (Illinois variant of the false position).
template <typename Function>
double FalsePosition(const Function& f, double inside, double outside, double there) {
  double here = f(inside);
  int last = 0;  // which end moved
  for (int k = 0; k < kMostWidenings; ++k) {
    const double middle = inside + (outside - inside) * (-here) / (there - here);
    const double value = f(middle);
    if (std::abs(value) < 1e-4 || std::abs(outside - inside) < 1e-5 * std::max(outside, inside)) return middle;
    if (value > 0.0) {
      outside = middle;
      there = value;
      if (last > 0) here *= 0.5;
      last = 1;
    } else {
      inside = middle;
      here = value;
      if (last < 0) there *= 0.5;
      last = -1;
    }
  }
  return 0.5 * (inside + outside);
}

}  // namespace

RestrictedLikelihood::RestrictedLikelihood(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const CalibrationProblem reference = WithReferenceDeviations(problem);
  const std::vector<int> observations = reference.CalibrationObservations();
  Linearization all = Linearize(reference, parameters, observations, parameters.EstimatedCoordinates(),
                                ObservationNoise(reference, observations, kFallbackSigma), LatentTreatment::kIgnore);
  const int rows = all.num_rows();
  columns_ = all.num_columns();
  AppendPriors(parameters, &all);
  dof_ = all.num_rows() - columns_;
  if (columns_ == 0) StandIn(&all);
  columns_ = static_cast<int>(all.jacobian.cols());
  const Eigen::VectorXd scale = all.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse().transpose();
  all.jacobian = Eigen::MatrixXd(all.jacobian * scale.asDiagonal());
  const Eigen::MatrixXd priors = all.jacobian.bottomRows(all.num_rows() - rows);
  const Eigen::VectorXd prior_residual = all.residual.tail(all.num_rows() - rows);
  prior_normal_ = priors.transpose() * priors;
  prior_product_ = priors.transpose() * prior_residual;
  prior_square_ = prior_residual.squaredNorm();
  rest_normal_ = Eigen::MatrixXd::Zero(columns_, columns_);
  rest_product_ = Eigen::VectorXd::Zero(columns_);
  for (const auto& [visit, indices] : RowsByVisit(reference, observations)) {
    const Eigen::MatrixXd deviation = all.latent(indices, Eigen::all);
    // L = Q [R; 0]: V = a 1 + L v L' is block diagonal in the rotated rows Q'r, Q'J, and a 1 alone below R. Those rows
    // are summed once, whatever the variances.
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(deviation);
    Eigen::MatrixXd own(deviation.rows(), columns_ + 1);
    own << all.jacobian(indices, Eigen::all), all.residual(indices);
    own = TransposedQ(qr, std::move(own));
    const Eigen::MatrixXd jacobian = own.leftCols(columns_);
    const Eigen::VectorXd residual = own.col(columns_);
    const int touched = static_cast<int>(std::min(deviation.rows(), deviation.cols()));
    const int rest = static_cast<int>(deviation.rows()) - touched;
    const Eigen::MatrixXd upper = qr.matrixQR().topRows(touched).triangularView<Eigen::Upper>();
    visits_.push_back({residual.head(touched), jacobian.topRows(touched), upper});
    const Eigen::MatrixXd below = jacobian.bottomRows(rest);
    rest_normal_ += below.transpose() * below;
    rest_product_ += below.transpose() * residual.tail(rest);
    rest_square_ += residual.tail(rest).squaredNorm();
    rest_rows_ += rest;
  }
}

RestrictedLikelihood::Evaluation RestrictedLikelihood::Evaluate(const Eigen::VectorXd& variances,
                                                                const std::vector<DeviationGroup>& groups,
                                                                bool with_derivatives) const {
  const int n = static_cast<int>(variances.size());
  const double a = variances[0];
  struct Factored {
    Eigen::LLT<Eigen::MatrixXd> root;
    Eigen::MatrixXd jacobian;  // V^-1 J
    Eigen::VectorXd residual;  // V^-1 r
  };
  std::vector<Factored> factored;
  factored.reserve(visits_.size());
  Evaluation result;
  result.deviance = rest_rows_ * std::log(a);
  Eigen::MatrixXd normal = rest_normal_ / a + prior_normal_;
  Eigen::VectorXd product = rest_product_ / a + prior_product_;
  double square = rest_square_ / a + prior_square_;
  for (const Visit& visit : visits_) {
    const int rows = static_cast<int>(visit.residual.size());
    Eigen::MatrixXd v = a * Eigen::MatrixXd::Identity(rows, rows);
    for (size_t g = 0; g < groups.size(); ++g) {
      for (const int j : groups[g].joints) {
        const Eigen::VectorXd moved = visit.deviation.col(j);
        v.noalias() += (variances[g + 1] * moved) * moved.transpose();
      }
    }
    Factored f;
    f.root.compute(v);
    f.jacobian = f.root.solve(visit.jacobian);
    f.residual = f.root.solve(visit.residual);
    result.deviance += LogDeterminant(f.root);
    normal += visit.jacobian.transpose() * f.jacobian;
    product += f.jacobian.transpose() * visit.residual;
    square += visit.residual.dot(f.residual);
    factored.push_back(std::move(f));
  }
  // N = J'V^-1 J, x = N^-1 J'V^-1 r:  r'P r = r'V^-1 r - x'J'V^-1 r,  ln|N| = 2 sum ln diag chol(N).
  const Eigen::LLT<Eigen::MatrixXd> root(normal);
  const Eigen::VectorXd x = root.solve(product);
  result.chi2 = square - product.dot(x);
  result.deviance += LogDeterminant(root) + result.chi2;
  result.inverse = InverseOfPositive(normal);
  if (!with_derivatives) return result;

  // dD/dv_i = tr(V^-1 V_i) - tr(N^-1 J'V^-1 V_i V^-1 J) - e'V_i e,   e = P r.
  result.gradient = Eigen::VectorXd::Zero(n);
  result.derivative.assign(n, Eigen::MatrixXd::Zero(columns_, columns_));
  Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(columns_, n);  // J'V^-1 V_i e
  Eigen::MatrixXd info = Eigen::MatrixXd::Zero(n, n);         // (V_i e)'V^-1 (V_k e)
  // Rows that no deviation touches: V = a, V_0 = 1, e = (r - J x) / a.
  const Eigen::VectorXd rest_fitted = rest_normal_ * x, rest_pull = rest_product_ - rest_fitted;
  const double rest_left = rest_square_ - 2.0 * rest_product_.dot(x) + x.dot(rest_fitted);
  result.gradient[0] += rest_rows_ / a - rest_left / (a * a);
  result.derivative[0] += rest_normal_ / (a * a);
  pull.col(0) += rest_pull / (a * a);
  info(0, 0) += rest_left / (a * a * a);
  for (size_t s = 0; s < visits_.size(); ++s) {
    const Visit& visit = visits_[s];
    const Factored& f = factored[s];
    const int rows = static_cast<int>(visit.residual.size());
    const Eigen::VectorXd e = f.residual - f.jacobian * x;
    Eigen::MatrixXd moved(rows, n);  // V_i e
    for (int i = 0; i < n; ++i) {
      Eigen::MatrixXd factor = Eigen::MatrixXd::Identity(rows, rows);  // V_i = factor factor'
      if (i > 0) factor = visit.deviation(Eigen::all, groups[i - 1].joints);
      const Eigen::MatrixXd seen = factor.transpose() * f.jacobian;
      const Eigen::VectorXd along = factor.transpose() * e;
      result.gradient[i] += f.root.matrixL().solve(factor).squaredNorm() - along.squaredNorm();
      result.derivative[i] += seen.transpose() * seen;
      moved.col(i) = factor * along;
    }
    pull += f.jacobian.transpose() * moved;
    const Eigen::MatrixXd weighed = f.root.solve(moved);  // V^-1 V_i e
    info += moved.transpose() * weighed;
  }
  for (int i = 0; i < n; ++i) {
    result.gradient[i] -= result.inverse.cwiseProduct(result.derivative[i]).sum();
  }
  // y'P V_i P V_k P y with e = P y:  (V_i e)'V^-1 (V_k e) - (V_i e)'V^-1 J N^-1 J'V^-1 (V_k e). Average information:
  // the mean of observed and expected information (Gilmour, Thompson and Cullis 1995).
  const Eigen::MatrixXd refitted = result.inverse * pull;
  result.hessian = info - pull.transpose() * refitted;
  return result;
}

bool RestrictedLikelihood::Minimise(const std::vector<bool>& is_free, const std::vector<DeviationGroup>& groups,
                                    Eigen::VectorXd* variances) const {
  const auto lowest = [](int i) { return i == 0 ? kSmallestInstrument : 0.0; };
  for (int iteration = 0; iteration < kMaxNewton; ++iteration) {
    const Evaluation here = Evaluate(*variances, groups, true);
    std::vector<int> moving;
    for (int i = 0; i < variances->size(); ++i) {
      const bool rests = (*variances)[i] <= lowest(i) && here.gradient[i] >= 0.0;
      if (is_free[i] && !rests) moving.push_back(i);
    }
    if (moving.empty()) return true;
    Eigen::MatrixXd hessian = here.hessian(moving, moving);
    hessian.diagonal() *= 1.0 + 1e-9;
    const Eigen::VectorXd gradient = here.gradient(moving);
    Eigen::LDLT<Eigen::MatrixXd> factor(hessian);
    Eigen::VectorXd step = -factor.solve(gradient);
    if (factor.info() != Eigen::Success || !step.allFinite() || step.dot(gradient) >= 0.0) {
      step = -gradient.cwiseQuotient(here.hessian.diagonal()(moving).cwiseMax(1e-12));
    }
    double scale = 1.0;
    bool moved = false;
    for (int halving = 0; halving < kMaxHalvings && !moved; ++halving, scale *= 0.5) {
      Eigen::VectorXd trial = *variances;
      double promised = 0.0;
      for (size_t m = 0; m < moving.size(); ++m) {
        const int i = moving[m];
        // Never below a tenth in one step, but for variances that are as good as none.
        const double floor = i == 0 || trial[i] > 1e-4 ? 0.1 * trial[i] : 0.0;
        trial[i] = std::max({trial[i] + scale * step[m], floor, lowest(i)});
        promised -= gradient[m] * (trial[i] - (*variances)[i]);
      }
      if (promised < kConverged) return true;
      const double there = Evaluate(trial, groups, false).deviance;
      // Armijo: at least a ten-thousandth of what the slope promises.
      if (!(there < here.deviance - 1e-4 * promised)) continue;
      *variances = trial;
      moved = true;
    }
    if (!moved) return true;  // rounding: no step lowers the deviance
  }
  return false;
}

Eigen::VectorXd RestrictedLikelihood::StartVariances(const std::vector<DeviationGroup>& groups) const {
  Eigen::VectorXd variances(groups.size() + 1);
  variances[0] = 1.0;
  for (size_t g = 0; g < groups.size(); ++g) variances[g + 1] = groups[g].variance / (kReference * kReference);
  return variances;
}

double RestrictedLikelihood::Deviance(double instrument, const std::vector<DeviationGroup>& groups) const {
  Eigen::VectorXd variances = StartVariances(groups);
  variances[0] = instrument;
  return Evaluate(variances, groups, false).deviance;
}

RemlFit RestrictedLikelihood::Maximise(bool estimate_instrument, const std::vector<DeviationGroup>& groups) const {
  const int n = static_cast<int>(groups.size()) + 1;
  std::vector<bool> is_free = {estimate_instrument};
  for (const DeviationGroup& group : groups) is_free.push_back(group.estimated);
  // Several starts of all free deviations together: the deviance can have two valleys (instrument or robot).
  Eigen::VectorXd best = StartVariances(groups);
  if (estimate_instrument) {
    double square = rest_square_, rows = rest_rows_;
    for (const Visit& visit : visits_) {
      if (rest_rows_ >= dof_ / 4) break;  // enough rows that no deviation touches
      square += visit.residual.squaredNorm();
      rows += static_cast<double>(visit.residual.size());
    }
    best[0] = std::max(10.0 * kSmallestInstrument, square / std::max(1.0, rows));
  }
  double lowest = std::numeric_limits<double>::infinity();
  std::vector<double> starts = {-1.0};
  if (std::count(is_free.begin() + 1, is_free.end(), true) > 0) starts = {-1.0, 0.01, 1.0, 25.0, 400.0};
  const Eigen::VectorXd given = best;
  for (const double start : starts) {
    Eigen::VectorXd trial = given;
    for (int i = 1; i < n; ++i) {
      if (is_free[i] && start >= 0.0) trial[i] = start;
    }
    const double deviance = Evaluate(trial, groups, false).deviance;
    if (!(deviance < lowest)) continue;
    lowest = deviance;
    best = trial;
  }
  RemlFit fit;
  fit.converged = Minimise(is_free, groups, &best);
  const Evaluation here = Evaluate(best, groups, true);
  fit.deviance = here.deviance;
  fit.chi2 = here.chi2;
  fit.variances = best;
  fit.variances.tail(n - 1) *= kReference * kReference;
  fit.covariance = Eigen::MatrixXd::Zero(n, n);
  std::vector<int> inner;
  for (int i = 0; i < n; ++i) {
    if (is_free[i] && best[i] > (i == 0 ? kSmallestInstrument : 0.0)) inner.push_back(i);
  }
  if (inner.empty()) return fit;
  // D = -2 ln L: its second derivatives are twice the information.
  const Eigen::MatrixXd info = 0.5 * here.hessian(inner, inner);
  const Eigen::MatrixXd inverse = info.ldlt().solve(Eigen::MatrixXd::Identity(inner.size(), inner.size()).eval());
  const auto unit = [](int i) { return i == 0 ? 1.0 : kReference * kReference; };
  for (size_t r = 0; r < inner.size(); ++r) {
    for (size_t c = 0; c < inner.size(); ++c) {
      fit.covariance(inner[r], inner[c]) = inverse(r, c) * unit(inner[r]) * unit(inner[c]);
    }
  }
  return fit;
}

void RestrictedLikelihood::ProfileInterval(const RemlFit& fit, bool estimate_instrument,
                                           const std::vector<DeviationGroup>& groups, int i, double* low,
                                           double* high) const {
  std::vector<bool> is_free = {estimate_instrument};
  for (const DeviationGroup& group : groups) is_free.push_back(group.estimated);
  is_free[i] = false;
  const double unit = i == 0 ? 1.0 : kReference;  // of the standard deviation
  Eigen::VectorXd optimum = fit.variances;
  optimum.tail(groups.size()) /= kReference * kReference;
  const double reach = NormalQuantile(0.975);
  // Root of the deviance's rise less its 95 % value: nearly straight in the standard deviation.
  const auto excess = [&](double sigma) {
    Eigen::VectorXd variances = optimum;
    variances[i] = std::max(sigma * sigma, i == 0 ? kSmallestInstrument : 0.0);
    Minimise(is_free, groups, &variances);
    return std::sqrt(std::max(0.0, Evaluate(variances, groups, false).deviance - fit.deviance)) - reach;
  };
  const double center = std::sqrt(optimum[i]);
  // sd(sigma) = sd(sigma^2) / (2 sigma).
  const double spread = center > 0.0 ? std::sqrt(fit.covariance(i, i)) / (unit * unit) / (2.0 * center) : 0.0;
  const double guess = spread > 0.0 ? 2.5 * spread : std::max(0.2 * center, 0.05);
  double inside = center, outside = std::max(0.0, center - guess);
  double there = excess(outside);
  while (there <= 0.0 && outside > 0.0) {
    inside = outside;
    outside = outside > 0.05 * center ? std::max(0.0, outside - guess) : 0.0;
    there = excess(outside);
  }
  *low = there <= 0.0 ? 0.0 : unit * FalsePosition(excess, inside, outside, there);
  inside = center;
  outside = center + guess;
  there = excess(outside);
  for (int k = 0; k < kMostWidenings && there <= 0.0; ++k) {
    inside = outside;
    outside = 1.5 * outside + guess;
    there = excess(outside);
  }
  *high = there > 0.0 ? unit * FalsePosition(excess, inside, outside, there) : std::numeric_limits<double>::infinity();
}

Eigen::VectorXd RestrictedLikelihood::Levers() const {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(visits_.front().deviation.cols());
  for (const Visit& visit : visits_) squares += visit.deviation.colwise().squaredNorm().transpose();
  return squares.cwiseSqrt();
}

Eigen::VectorXd RestrictedLikelihood::Satterthwaite(const RemlFit& fit,
                                                    const std::vector<DeviationGroup>& groups) const {
  Eigen::VectorXd variances = fit.variances;
  variances.tail(groups.size()) /= kReference * kReference;
  const Evaluation here = Evaluate(variances, groups, true);
  const int n = static_cast<int>(variances.size());
  Eigen::VectorXd unit = Eigen::VectorXd::Constant(n, 1.0 / (kReference * kReference));
  unit[0] = 1.0;
  const Eigen::MatrixXd covariance = unit.asDiagonal() * fit.covariance * unit.asDiagonal();
  // d C_cc / d v_i = (C J'V^-1 V_i V^-1 J C)_cc
  Eigen::MatrixXd slopes(columns_, n);
  for (int i = 0; i < n; ++i) {
    const Eigen::MatrixXd moved = here.inverse * here.derivative[i];
    slopes.col(i) = moved.cwiseProduct(here.inverse).rowwise().sum();  // C is symmetric
  }
  Eigen::VectorXd dof(columns_);
  for (int c = 0; c < columns_; ++c) {
    // nu = 2 C^2 / var(C), var(C) = g' cov(v) g with g = dC/dv (Satterthwaite 1946).
    const Eigen::VectorXd slope = slopes.row(c);
    const double spread = slope.dot(covariance * slope);
    const double value = here.inverse(c, c);
    dof[c] = spread > 0.0 ? 2.0 * value * value / spread : std::numeric_limits<double>::infinity();
  }
  return dof;
}

}  // namespace sagitta
