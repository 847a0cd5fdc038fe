#include "estimator/noise/variance_components.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estimator/least_squares/all_joints.h"
#include "estimator/least_squares/normal_algebra.h"
#include "estimator/least_squares/row_sums.h"
#include "estimator/statistics/distributions.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

constexpr double kReference = 1e-5;           // rad or m: deviations are counted in these
constexpr int kMaxNewton = 100;               // a guard: kConverged ends them
constexpr int kMaxHalvings = 30;              // 2^-30 = 1e-9, as kConverged
constexpr int kMostWidenings = 40;            // 1.5^40 = 1e7: an end beyond that is open
constexpr double kSmallestInstrument = 1e-8;  // variance factor: a ten-thousandth of the stated sigma
constexpr double kConverged = 1e-9;           // of the deviance

// Every joint deviates by the reference.
CalibrationProblem WithReferenceDeviations(CalibrationProblem problem) {
  problem.latent = WithAllJoints(std::move(problem.latent), problem.robot().num_joints());
  problem.latent.sigmas *= kReference;
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

// R with R'R = F F', of no more rows than F has columns or rows.
Eigen::MatrixXd Shortened(const Eigen::MatrixXd& factor) {
  if (factor.cols() <= factor.rows()) return factor.transpose();
  return Eigen::HouseholderQR<Eigen::MatrixXd>(factor.transpose())
      .matrixQR()
      .topRows(factor.rows())
      .triangularView<Eigen::Upper>();
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

// D = -2 ln L: its second derivatives are twice the information. Of variances that are free and not at their least.
// noises: how many of them are of readings.
Eigen::MatrixXd CovarianceOf(const Eigen::VectorXd& variances, int noises, const std::vector<bool>& is_free,
                             const Eigen::MatrixXd& hessian) {
  const long n = variances.size();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  std::vector<int> inner;
  for (int i = 0; i < n; ++i) {
    if (is_free[i] && variances[i] > (i < noises ? kSmallestInstrument : 0.0)) inner.push_back(i);
  }
  if (inner.empty()) return covariance;
  const Eigen::MatrixXd info = 0.5 * hessian(inner, inner);
  const Eigen::MatrixXd inverse = info.ldlt().solve(Eigen::MatrixXd::Identity(inner.size(), inner.size()).eval());
  const auto unit = [noises](int i) { return i < noises ? 1.0 : kReference * kReference; };
  for (size_t r = 0; r < inner.size(); ++r) {
    for (size_t c = 0; c < inner.size(); ++c) {
      covariance(inner[r], inner[c]) = inverse(r, c) * unit(inner[r]) * unit(inner[c]);
    }
  }
  return covariance;
}

}  // namespace

RestrictedLikelihood::RestrictedLikelihood(const CalibrationProblem& problem, const ParameterSet& parameters,
                                           bool rotations_apart)
    : num_noises_(rotations_apart ? 2 : 1) {
  const CalibrationProblem reference = WithReferenceDeviations(problem);
  const std::vector<int> observations = reference.CalibrationObservations();
  Linearization all = Linearize(reference, parameters, observations, parameters.EstimatedCoordinates(),
                                ObservationNoise(reference, observations, kFallbackSigma), LatentTreatment::kIgnore);
  const int measured = all.num_rows();
  columns_ = all.num_columns();
  AppendPriors(parameters, &all);
  dof_ = all.num_rows() - columns_;
  if (columns_ == 0) StandIn(&all);
  columns_ = static_cast<int>(all.jacobian.cols());
  const Eigen::VectorXd scale = all.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse().transpose();
  all.jacobian = Eigen::MatrixXd(all.jacobian * scale.asDiagonal());
  Rows rows(all.num_rows(), columns_ + 1);
  rows << all.jacobian, all.residual;
  const auto priors = rows.bottomRows(all.num_rows() - measured);
  prior_ = priors.transpose() * priors;
  rest_.assign(num_noises_, {Eigen::MatrixXd::Zero(columns_ + 1, columns_ + 1), 0});
  rows_.resize(measured, columns_ + 1);
  int touched = 0;
  for (const auto& [visit, indices] : RowsByVisit(reference, observations)) {
    std::vector<int> kinds[2];
    for (const int row : indices) {
      const bool is_point = reference.data().observations[observations[row / 3]].is_point();
      kinds[rotations_apart && !is_point].push_back(row);
    }
    AddVisit(rows, all.latent, kinds[0], kinds[1], &touched);
  }
  rows_.conservativeResize(touched, Eigen::NoChange);
}

// Of either kind L = Q [R; 0]: V is block diagonal in the rotated rows Q'r, Q'J, and its variance times 1 alone below
// R. Those rows are summed once, whatever the variances.
void RestrictedLikelihood::AddVisit(const Rows& rows, const Eigen::MatrixXd& deviation,
                                    const std::vector<int>& of_points, const std::vector<int>& of_rotations,
                                    int* touched) {
  Visit visit{*touched, 0, Eigen::MatrixXd(0, deviation.cols())};
  for (int kind = 0; kind < num_noises_; ++kind) {
    const std::vector<int>& indices = kind == 0 ? of_points : of_rotations;
    if (indices.empty()) continue;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(deviation(indices, Eigen::all));
    const Eigen::MatrixXd own = TransposedQ(qr, rows(indices, Eigen::all));
    const auto count = static_cast<int>(std::min(static_cast<Eigen::Index>(indices.size()), deviation.cols()));
    visit.deviation.conservativeResize(visit.deviation.rows() + count, Eigen::NoChange);
    visit.deviation.bottomRows(count) = qr.matrixQR().topRows(count).triangularView<Eigen::Upper>();
    if (kind == 0) visit.of_points = count;
    rows_.middleRows(*touched, count) = own.topRows(count);
    *touched += count;
    const auto below = own.bottomRows(own.rows() - count);
    rest_[kind].products += below.transpose() * below;
    rest_[kind].rows += static_cast<int>(below.rows());
  }
  visits_.push_back(std::move(visit));
}

Eigen::VectorXd RestrictedLikelihood::OwnVariances(const Visit& visit, const Eigen::VectorXd& variances) const {
  Eigen::VectorXd own = Eigen::VectorXd::Constant(visit.deviation.rows(), variances[num_noises_ - 1]);
  own.head(visit.of_points).setConstant(variances[0]);
  return own;
}

Eigen::MatrixXd RestrictedLikelihood::FactorOf(const Visit& visit, int i,
                                               const std::vector<DeviationGroup>& groups) const {
  if (i >= num_noises_) return visit.deviation(Eigen::all, groups[i - num_noises_].joints);
  const Eigen::Index rows = visit.deviation.rows();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(rows, rows);
  return i == 0 ? identity.leftCols(visit.of_points) : identity.rightCols(rows - visit.of_points);
}

std::vector<bool> RestrictedLikelihood::FreeOnes(bool estimate_instrument,
                                                 const std::vector<DeviationGroup>& groups) const {
  std::vector<bool> is_free(num_noises_, true);
  is_free[0] = estimate_instrument;
  for (const DeviationGroup& group : groups) is_free.push_back(group.estimated);
  return is_free;
}

// V = L L', visit by visit, and L^-1 [J r].
struct RestrictedLikelihood::Whitened {
  std::vector<Eigen::LLT<Eigen::MatrixXd>> roots;
  Rows rows;
  double log_det = 0.0;  // ln |V|
};

RestrictedLikelihood::Whitened RestrictedLikelihood::Whiten(const Eigen::VectorXd& variances,
                                                            const std::vector<DeviationGroup>& groups) const {
  Whitened result;
  result.rows = rows_;
  for (const Visit& visit : visits_) {
    const Eigen::Index rows = visit.deviation.rows();
    Eigen::MatrixXd v = OwnVariances(visit, variances).asDiagonal();
    for (size_t g = 0; g < groups.size(); ++g) {
      const Eigen::MatrixXd moved = visit.deviation(Eigen::all, groups[g].joints);
      v += variances[num_noises_ + static_cast<Eigen::Index>(g)] * moved.lazyProduct(moved.transpose());
    }
    result.roots.emplace_back(v);
    result.roots.back().matrixL().solveInPlace(result.rows.middleRows(visit.first, rows));
    result.log_det += LogDeterminant(result.roots.back());
  }
  return result;
}

RestrictedLikelihood::Evaluation RestrictedLikelihood::Evaluate(const Eigen::VectorXd& variances,
                                                                const std::vector<DeviationGroup>& groups,
                                                                bool with_derivatives) const {
  const Whitened whitened = Whiten(variances, groups);
  // [J r]'V^-1 [J r] of all rows.
  Eigen::MatrixXd products = SelfProduct(whitened.rows) + prior_;
  double log_det = whitened.log_det;
  for (int i = 0; i < num_noises_; ++i) {
    products += rest_[i].products / variances[i];
    log_det += rest_[i].rows * std::log(variances[i]);
  }
  const Eigen::MatrixXd normal = products.topLeftCorner(columns_, columns_);
  const Eigen::VectorXd product = products.col(columns_).head(columns_);
  // N = J'V^-1 J, x = N^-1 J'V^-1 r:  r'P r = r'V^-1 r - x'J'V^-1 r,  ln|N| = 2 sum ln diag chol(N).
  const Eigen::LLT<Eigen::MatrixXd> root(normal);
  Evaluation result;
  result.fitted = root.solve(product);
  const double chi2 = products(columns_, columns_) - product.dot(result.fitted);
  result.deviance = log_det + chi2;
  result.deviance += LogDeterminant(root);
  if (!with_derivatives) return result;
  result.inverse = InverseOfPositive(normal);
  Differentiate(whitened, variances, groups, &result);
  return result;
}

// dD/dv_i = tr(V^-1 V_i) - tr(N^-1 J'V^-1 V_i V^-1 J) - e'V_i e,   e = P r.   With V_i = F_i F_i', all in the rows
// L^-1 J and L^-1 r - L^-1 J x = L'e of a visit, and F_i standing for L^-1 F_i:
//
//   tr(V^-1 V_i) = |F_i|^2,  e'V_i e = |F_i'L'e|^2,  J'V^-1 V_i V^-1 J = |F_i'(L^-1 J)|^2,  L^-1 V_i e = F_i F_i'L'e
void RestrictedLikelihood::Differentiate(const Whitened& whitened, const Eigen::VectorXd& variances,
                                         const std::vector<DeviationGroup>& groups, Evaluation* result) const {
  const Eigen::Index n = variances.size();
  Eigen::VectorXd combination(columns_ + 1);  // [J r] to the residuals that are left
  combination << -result->fitted, 1.0;
  const Eigen::VectorXd left = whitened.rows * combination;
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(left.size(), n);  // L^-1 V_i e
  result->gradient = Eigen::VectorXd::Zero(n);
  std::vector<SumOfRows> seen;
  for (Eigen::Index i = 0; i < n; ++i) seen.emplace_back(columns_);
  for (size_t s = 0; s < visits_.size(); ++s) {
    const Visit& visit = visits_[s];
    const Eigen::Index rows = visit.deviation.rows();
    const auto own_left = left.segment(visit.first, rows);
    for (Eigen::Index i = 0; i < n; ++i) {
      Eigen::MatrixXd factor = FactorOf(visit, static_cast<int>(i), groups);
      if (factor.cols() == 0) continue;
      whitened.roots[s].matrixL().solveInPlace(factor);
      const Eigen::VectorXd along = factor.transpose() * own_left;
      result->gradient[i] += factor.squaredNorm() - along.squaredNorm();
      moved.col(i).segment(visit.first, rows) = factor * along;
      const Rows own = Shortened(factor).lazyProduct(whitened.rows.block(visit.first, 0, rows, columns_));
      for (Eigen::Index r = 0; r < own.rows(); ++r) seen[static_cast<size_t>(i)].Add(own.row(r).data());
    }
  }
  Eigen::MatrixXd pull = whitened.rows.leftCols(columns_).transpose() * moved;  // J'V^-1 V_i e
  Eigen::MatrixXd info = moved.transpose() * moved;                             // (V_i e)'V^-1 (V_k e)
  result->derivative.clear();
  for (SumOfRows& sum : seen) result->derivative.push_back(sum.Total());
  // Rows that no deviation touches: V = a, V_0 = 1, e = (r - J x) / a.
  for (int i = 0; i < num_noises_; ++i) {
    const double a = variances[i];
    const Eigen::VectorXd rest_pull = rest_[i].products * combination;
    const double rest_left = combination.dot(rest_pull);
    result->gradient[i] += rest_[i].rows / a - rest_left / (a * a);
    result->derivative[i] += rest_[i].products.topLeftCorner(columns_, columns_) / (a * a);
    pull.col(i) += rest_pull.head(columns_) / (a * a);
    info(i, i) += rest_left / (a * a * a);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    result->gradient[i] -= result->inverse.cwiseProduct(result->derivative[static_cast<size_t>(i)]).sum();
  }
  // y'P V_i P V_k P y with e = P y:  (V_i e)'V^-1 (V_k e) - (V_i e)'V^-1 J N^-1 J'V^-1 (V_k e). Average information:
  // the mean of observed and expected information (Gilmour, Thompson and Cullis 1995).
  result->hessian = info - pull.transpose() * (result->inverse * pull);
}

bool RestrictedLikelihood::Minimise(const std::vector<bool>& is_free, const std::vector<DeviationGroup>& groups,
                                    Eigen::VectorXd* variances) const {
  const auto lowest = [this](int i) { return i < num_noises_ ? kSmallestInstrument : 0.0; };
  Evaluation here = Evaluate(*variances, groups, true);
  for (int iteration = 0; iteration < kMaxNewton; ++iteration) {
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
        const double floor = i < num_noises_ || trial[i] > 1e-4 ? 0.1 * trial[i] : 0.0;
        trial[i] = std::max({trial[i] + scale * step[m], floor, lowest(i)});
        promised -= gradient[m] * (trial[i] - (*variances)[i]);
      }
      if (promised < kConverged) return true;
      Evaluation there = Evaluate(trial, groups, true);
      // Armijo: at least a ten-thousandth of what the slope promises.
      if (!(there.deviance < here.deviance - 1e-4 * promised)) continue;
      here = std::move(there);
      *variances = trial;
      moved = true;
    }
    if (!moved) return true;  // rounding: no step lowers the deviance
  }
  return false;
}

Eigen::VectorXd RestrictedLikelihood::StartVariances(const std::vector<DeviationGroup>& groups) const {
  const auto count = static_cast<Eigen::Index>(groups.size());
  Eigen::VectorXd variances = Eigen::VectorXd::Ones(num_noises_ + count);
  for (Eigen::Index g = 0; g < count; ++g) {
    variances[num_noises_ + g] = groups[static_cast<size_t>(g)].variance / (kReference * kReference);
  }
  return variances;
}

double RestrictedLikelihood::Deviance(double instrument, const std::vector<DeviationGroup>& groups) const {
  Eigen::VectorXd variances = StartVariances(groups);
  variances[0] = instrument;
  return Evaluate(variances, groups, false).deviance;
}

RemlFit RestrictedLikelihood::Maximise(bool estimate_instrument, const std::vector<DeviationGroup>& groups) const {
  const std::vector<bool> is_free = FreeOnes(estimate_instrument, groups);
  RemlFit fit;
  fit.variances = BestStart(is_free, groups);
  fit.converged = Minimise(is_free, groups, &fit.variances);
  const Evaluation here = Evaluate(fit.variances, groups, true);
  fit.deviance = here.deviance;
  fit.covariance = CovarianceOf(fit.variances, num_noises_, is_free, here.hessian);
  fit.variances.tail(static_cast<long>(groups.size())) *= kReference * kReference;
  return fit;
}

double RestrictedLikelihood::MeanSquare(int noise) const {
  const Rest& rest = rest_[noise];
  double square = rest.products(columns_, columns_), rows = rest.rows;
  // Too few rows that no deviation touches.
  const bool are_few = num_noises_ == 1 ? rest.rows < dof_ / 4 : rest.rows == 0;
  for (size_t s = 0; s < visits_.size() && are_few; ++s) {
    const Visit& visit = visits_[s];
    const int count = static_cast<int>(visit.deviation.rows());
    const int first = noise == 0 ? 0 : visit.of_points, own = noise == 0 ? visit.of_points : count - visit.of_points;
    square += rows_.block(visit.first + first, columns_, own, 1).squaredNorm();
    rows += own;
  }
  return std::max(10.0 * kSmallestInstrument, square / std::max(1.0, rows));
}

// Several starts of all free deviations together: the deviance can have two valleys (instrument or robot).
Eigen::VectorXd RestrictedLikelihood::BestStart(const std::vector<bool>& is_free,
                                                const std::vector<DeviationGroup>& groups) const {
  Eigen::VectorXd given = StartVariances(groups);
  for (int i = 0; i < num_noises_; ++i) {
    if (is_free[i]) given[i] = MeanSquare(i);
  }
  // As given; variances of 1, 10, 50 and 200 urad (um), from small arms to worn ones.
  std::vector<double> starts = {-1.0};
  if (std::count(is_free.begin() + num_noises_, is_free.end(), true) > 0) starts = {-1.0, 0.01, 1.0, 25.0, 400.0};
  Eigen::VectorXd best = given;
  double lowest = std::numeric_limits<double>::infinity();
  for (const double start : starts) {
    Eigen::VectorXd trial = given;
    for (size_t i = static_cast<size_t>(num_noises_); i < is_free.size(); ++i) {
      if (is_free[i] && start >= 0.0) trial[static_cast<Eigen::Index>(i)] = start;
    }
    const double deviance = Evaluate(trial, groups, false).deviance;
    if (!(deviance < lowest)) continue;
    lowest = deviance;
    best = trial;
  }
  return best;
}

void RestrictedLikelihood::ProfileInterval(const RemlFit& fit, bool estimate_instrument,
                                           const std::vector<DeviationGroup>& groups, int i, double* low,
                                           double* high) const {
  std::vector<bool> is_free = FreeOnes(estimate_instrument, groups);
  is_free[i] = false;
  const double unit = i < num_noises_ ? 1.0 : kReference;  // of the standard deviation
  Eigen::VectorXd optimum = fit.variances;
  optimum.tail(groups.size()) /= kReference * kReference;
  const double reach = NormalQuantile(kUpperOf95);
  // Root of the deviance's rise less its 95 % value: nearly straight in the standard deviation.
  const auto excess = [&](double sigma) {
    Eigen::VectorXd variances = optimum;
    variances[i] = std::max(sigma * sigma, i < num_noises_ ? kSmallestInstrument : 0.0);
    Minimise(is_free, groups, &variances);
    return std::sqrt(std::max(0.0, Evaluate(variances, groups, false).deviance - fit.deviance)) - reach;
  };
  const double center = std::sqrt(optimum[i]);
  // sd(sigma) = sd(sigma^2) / (2 sigma).
  const double spread = center > 0.0 ? std::sqrt(fit.covariance(i, i)) / (unit * unit) / (2.0 * center) : 0.0;
  // A little beyond the 1.96 deviations where a parabola's end would be.
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
  unit.head(num_noises_).setOnes();
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
