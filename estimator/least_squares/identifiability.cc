#include "estimator/least_squares/identifiability.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "estimator/least_squares/row_sums.h"
#include "estimator/report/least_squares_words.h"

namespace sagitta {
namespace {

constexpr double kShownComponent = 0.05;    // of the largest, in words and lists
constexpr double kNumericallyZero = 1e-13;  // of the largest singular value: rounding of 10^5 rows, 1e-16 sqrt(10^5)
constexpr double kWellDetermined = 1e6;     // times better than its limit (HoldLimits)
constexpr double kPeeled = 0.03;            // of the largest singular value, those found at once
constexpr double kLeastSigma = 1e-9;        // of an exact fit, stated sigmas
constexpr double kAsGoodAColumn = 0.9;      // of the largest: another column in its place costs no digit
constexpr double kWeakPerHoldLimit = 0.2;   // 1 mm of 5 mm, 1 mrad of 5 mrad

// Which member of a direction is held first: a geometric error has a nominal
// value to fall back on, a marker sometimes, a base never.
double HoldPreference(const Coordinate& coordinate) {
  if (coordinate.compensator_part == CompensatorPart::kL) return 10.0;  // the scale gauge is fixed by its file value
  if (coordinate.kind == CoordinateKind::kMarker) return 0.5;
  if (coordinate.kind == CoordinateKind::kBase) return 0.2;
  return 1.0;
}

// A column that alone is determined a million times better than its limit counts as determined that well: wide priors
// and limits of what hardly moves anything would else drown all others in rounding.
Eigen::VectorXd HoldLimits(const Linearization& linearization, const ParameterSet& parameters, double sigma) {
  Eigen::VectorXd limits(linearization.num_columns());
  for (int c = 0; c < limits.size(); ++c) {
    const Coordinate& coordinate = parameters.coordinates()[linearization.columns[c]];
    // A stated prior is knowledge: what it alone determines is not held.
    limits[c] = std::max(coordinate.hold_limit, 2.0 * coordinate.prior_sigma);
    const double determined = linearization.jacobian.col(c).norm() * limits[c] / std::max(sigma, kLeastSigma);
    if (determined > kWellDetermined) limits[c] *= kWellDetermined / determined;
  }
  return limits;
}

struct ScaledSvd {
  Eigen::VectorXd singular_values;
  Eigen::MatrixXd v;
};

// The R factor of the columns in units of their limits, so that tall problems stay cheap; exact for fewer rows than
// columns too.
Eigen::MatrixXd ScaledFactor(const Linearization& linearization, const Eigen::VectorXd& limits) {
  const int n = linearization.num_columns();
  if (AreMany(linearization)) return ScaledFactor(Condense(SumRows(linearization)), limits);
  Eigen::MatrixXd scaled = linearization.jacobian * limits.asDiagonal();
  if (scaled.rows() < n) scaled.conservativeResizeLike(Eigen::MatrixXd::Zero(n, n));
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(scaled);
  return qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
}

// Whether every singular value exceeds `limit` and what is numerically zero, said without any of them: none is smaller
// than 1 / |R^-1| (Frobenius).
bool AllAbove(const Eigen::MatrixXd& r, double limit) {
  if (!(r.diagonal().cwiseAbs().minCoeff() > 0.0)) return false;
  const Eigen::MatrixXd inverse = r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(r.rows(), r.cols()));
  return inverse.norm() * std::max(limit, kNumericallyZero * r.norm()) < 1.0;
}

// Largest first. Eigenvalues s^2 of R'R have an error of eps s_1^2, by which s is exact to 1e3 eps down to kPeeled s_1;
// what is left of the space is decomposed by itself, and so on: the smallest are as exact as by rotations of R
// (one-sided Jacobi), at a quarter of the cost.
ScaledSvd Decompose(const Eigen::MatrixXd& r) {
  const long n = r.cols();
  ScaledSvd svd{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Identity(n, n)};
  Eigen::MatrixXd left = r;
  for (long done = 0; done < n;) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(Eigen::MatrixXd(left.transpose() * left));
    const Eigen::VectorXd values = eigen.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
    const Eigen::MatrixXd vectors = eigen.eigenvectors().rowwise().reverse();
    svd.v.rightCols(n - done) = svd.v.rightCols(n - done) * vectors;
    if (!(values[0] > 0.0)) break;
    const long exact = (values.array() >= kPeeled * values[0]).count(), rest = n - done - exact;
    svd.singular_values.segment(done, exact) = values.head(exact);
    done += exact;
    if (rest == 0) break;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(left * vectors.rightCols(rest));
    left = qr.matrixQR().topRows(rest).triangularView<Eigen::Upper>();
  }
  return svd;
}

// As many columns as there are rows, each the first of those that are as good as the largest in what the chosen ones
// leave: neither rounding nor noise decides between columns that do the same, and campaigns of one robot hold the same.
std::vector<int> PivotColumns(Eigen::MatrixXd rows) {
  std::vector<int> chosen;
  for (long k = 0; k < rows.rows(); ++k) {
    const Eigen::VectorXd norms = rows.colwise().norm();
    const double good = kAsGoodAColumn * norms.maxCoeff();
    long first = 0;
    while (norms[first] < good) ++first;
    chosen.push_back(static_cast<int>(first));
    const Eigen::VectorXd way = rows.col(first).normalized();
    rows -= way * (way.transpose() * rows).eval();
  }
  return chosen;
}

// Largest first, small ones left out, unit norm.
std::vector<std::pair<std::string, double>> Components(const Eigen::VectorXd& direction,
                                                       const Linearization& linearization,
                                                       const ParameterSet& parameters) {
  std::vector<std::pair<std::string, double>> components;
  const double largest = direction.cwiseAbs().maxCoeff();
  double squared = 0.0;
  for (int c = 0; c < direction.size(); ++c) {
    if (std::abs(direction[c]) < kShownComponent * largest) continue;
    components.emplace_back(parameters.coordinates()[linearization.columns[c]].name, direction[c]);
    squared += direction[c] * direction[c];
  }
  std::stable_sort(components.begin(), components.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.second) > std::abs(b.second) * (1 + 1e-9); });
  for (auto& component : components) component.second /= std::sqrt(squared);
  return components;
}

Direction MakeDirection(const Eigen::VectorXd& vector, double sigma, const Linearization& linearization,
                        const ParameterSet& parameters) {
  Direction direction;
  direction.components = Components(vector, linearization, parameters);
  direction.sigma = sigma;
  direction.words = DirectionInWords(direction.components);
  direction.remedy = RemedyFor(direction.components);
  return direction;
}

// The space of some singular vectors (columns scaled by the limits) in reduced form: direction k moves pivot k by one
// and no other pivot, so that a parameter that is lost by itself is a direction by itself.
std::vector<Direction> ReducedDirections(const ScaledSvd& svd, const std::vector<int>& lost,
                                         const Linearization& linearization, const ParameterSet& parameters,
                                         double sigma, std::vector<int>* pivots) {
  const long n = linearization.num_columns();
  Eigen::MatrixXd space(n, static_cast<long>(lost.size()));
  for (size_t k = 0; k < lost.size(); ++k) space.col(static_cast<long>(k)) = svd.v.col(lost[k]);
  // One column to hold per lost direction: pivots of the (preferred) rows.
  Eigen::MatrixXd preferred = space.transpose();
  for (long c = 0; c < n; ++c) {
    preferred.col(c) *= HoldPreference(parameters.coordinates()[linearization.columns[c]]);
  }
  *pivots = PivotColumns(std::move(preferred));
  const Eigen::MatrixXd pivot_rows = space(*pivots, Eigen::all);
  const Eigen::MatrixXd reduced = space * pivot_rows.inverse();
  std::vector<Direction> directions;
  for (size_t k = 0; k < lost.size(); ++k) {
    const Eigen::VectorXd column = reduced.col(static_cast<long>(k)).normalized();
    // |J x| = |S V'x| (scaled columns): along x the standard deviation is sigma / |J x|.
    const double information = (svd.singular_values.asDiagonal() * (svd.v.transpose() * column)).norm();
    const bool zero = information <= kNumericallyZero * svd.singular_values[0];
    const double standard_deviation = zero ? std::numeric_limits<double>::infinity() : sigma / information;
    directions.push_back(MakeDirection(column, standard_deviation, linearization, parameters));
  }
  return directions;
}

// What is stated of a parameter stays true where rows scatter by more than is stated, and their information 1 / s^2 is
// less:   J'J / s^2 + (1 - 1 / s^2) / sigma^2,   times s^2.   Nothing where that adds nothing.
std::optional<Linearization> WithPriorsAsStated(const Linearization& linearization, const ParameterSet& parameters,
                                                double scale) {
  std::vector<std::pair<int, double>> added;  // column, root of its information
  for (int c = 0; scale > 1.0 && c < linearization.num_columns(); ++c) {
    const Coordinate& coordinate = parameters.coordinates()[linearization.columns[c]];
    if (coordinate.has_stated_prior()) added.emplace_back(c, std::sqrt(scale * scale - 1.0) / coordinate.prior_sigma);
  }
  if (added.empty()) return std::nullopt;
  const int rows = linearization.num_rows(), more = static_cast<int>(added.size());
  Linearization with = linearization;
  with.jacobian.conservativeResize(rows + more, Eigen::NoChange);
  with.jacobian.bottomRows(more).setZero();
  with.residual.conservativeResize(rows + more);
  with.residual.tail(more).setZero();
  for (int k = 0; k < more; ++k) with.jacobian(rows + k, added[k].first) = added[k].second;
  return with;
}

}  // namespace

Unidentifiable FindUnidentifiable(const Linearization& rows, const ParameterSet& parameters, double sigma) {
  Unidentifiable result;
  const int n = rows.num_columns();
  if (n == 0) return result;
  const std::optional<Linearization> with_priors = WithPriorsAsStated(rows, parameters, sigma);
  const Linearization& linearization = with_priors ? *with_priors : rows;
  const Eigen::VectorXd limits = HoldLimits(linearization, parameters, sigma);
  const Eigen::MatrixXd factor = ScaledFactor(linearization, limits);
  if (AllAbove(factor, sigma)) return result;
  const ScaledSvd svd = Decompose(factor);
  std::vector<int> lost;
  for (int i = 0; i < n; ++i) {
    const bool zero = svd.singular_values[i] <= kNumericallyZero * svd.singular_values[0];
    if (zero || sigma > svd.singular_values[i]) lost.push_back(i);
  }
  if (lost.empty()) return result;
  result.directions = ReducedDirections(svd, lost, linearization, parameters, sigma, &result.columns);
  return result;
}

std::vector<Direction> FindWeak(const Linearization& linearization, const ParameterSet& parameters, double sigma) {
  std::vector<Direction> weak;
  const int n = linearization.num_columns();
  if (n == 0) return weak;
  Eigen::VectorXd limits(n);
  for (int c = 0; c < n; ++c) {
    const int coordinate = linearization.columns[c];
    const double hold_limit = parameters.coordinates()[coordinate].hold_limit;
    const double own = TraitsOf(parameters.coordinates()[coordinate].quantity).weak_limit;
    const double moved = kWeakPerHoldLimit * hold_limit;
    const double half = 0.5 * std::abs(parameters.Value(coordinate));
    // On its bound, or not yet estimated: by what it moves alone.
    const double of_value = half > kNumericallyZero * hold_limit ? std::min(half, moved) : moved;
    limits[c] = own > 0.0 ? own : of_value;
  }
  const Eigen::MatrixXd factor = ScaledFactor(linearization, limits);
  if (AllAbove(factor, sigma)) return weak;
  const ScaledSvd svd = Decompose(factor);
  std::vector<int> poor, pivots;
  for (int i = n - 1; i >= 0 && sigma > svd.singular_values[i]; --i) poor.push_back(i);
  if (poor.empty()) return weak;
  weak = ReducedDirections(svd, poor, linearization, parameters, sigma, &pivots);
  for (Direction& direction : weak) direction.words = PoorlyDetermined(direction.components, direction.words);
  return weak;
}

}  // namespace sagitta
