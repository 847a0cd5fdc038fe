#include "estimator/explanations/driver_functions.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "estimator/least_squares/normal_algebra.h"
#include "estimator/least_squares/row_sums.h"
#include "models/geometry.h"

namespace sagitta {

Eigen::MatrixXd OverKnots(const Eigen::VectorXd& x, const Knots& knots) {
  Eigen::MatrixXd functions(x.size(), knots.count);
  for (int k = 0; k < knots.count; ++k) {
    functions.col(k) = x.unaryExpr([&](double at) { return knots.Value(k, at); });
  }
  return functions;
}

Eigen::MatrixX2d Wave(const Eigen::VectorXd& phase) {
  Eigen::MatrixX2d wave(phase.size(), 2);
  wave << phase.array().cos().matrix(), phase.array().sin().matrix();
  return wave;
}

Eigen::ArrayXcd Turn(const Eigen::ArrayXd& x) {
  Eigen::ArrayXcd turn(x.size());
  turn.real() = x.cos();
  turn.imag() = x.sin();
  return turn;
}

std::vector<double> Distinct(const Eigen::VectorXd& x) {
  std::vector<double> sorted(x.begin(), x.end());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  return sorted;
}

std::vector<Gap> Gaps(const Eigen::VectorXd& x, int most) {
  const std::vector<double> sorted = Distinct(x);
  std::vector<Gap> gaps;
  if (sorted.size() < 2) return gaps;
  const size_t stride = (sorted.size() - 2) / static_cast<size_t>(most) + 1;  // of n values n - 1 gaps
  for (size_t i = stride; i < sorted.size(); i += stride) gaps.emplace_back(sorted[i - 1], sorted[i]);
  return gaps;
}

Eigen::VectorXd Jump(const Eigen::VectorXd& x, const Gap& gap) {
  return ((x.array() - gap.first) / (gap.second - gap.first)).cwiseMax(0.0).cwiseMin(1.0);
}

Eigen::MatrixXd Stretches(const Eigen::VectorXd& x, int most) {
  const std::vector<double> sorted = Distinct(x);
  const long count = std::min<long>(most, static_cast<long>(sorted.size()));
  Eigen::MatrixXd stretches = Eigen::MatrixXd::Zero(x.size(), count);
  for (long s = 0; s < x.size(); ++s) {
    const long place = std::lower_bound(sorted.begin(), sorted.end(), x[s]) - sorted.begin();
    stretches(s, place * count / static_cast<long>(sorted.size())) = 1.0;
  }
  return stretches;
}

std::vector<Eigen::Vector3d> HalfOfAllDirections(int count) {
  std::vector<Eigen::Vector3d> directions;
  for (int k = 0; k < count; ++k) directions.push_back(OnSpiral(k, (k + 0.5) / count));
  return directions;
}

namespace {

constexpr long kShotsPerProduct = 256;  // of some hundred columns, in the cache

// F'F
Eigen::MatrixXd ProductsOf(const Eigen::MatrixXd& functions) {
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(functions.cols(), functions.cols());
  for (long first = 0; first < functions.rows(); first += kShotsPerProduct) {
    products += SelfProduct(functions.middleRows(first, std::min(kShotsPerProduct, functions.rows() - first)));
  }
  return products;
}

// L with L L' = F'F but for `left` of its trace: Cholesky with pivots, which ends after as many columns as F has
// directions (Harbrecht, Peters and Schneider 2012, Appl. Numer. Math. 62, 428).
Eigen::MatrixXd LeadingColumns(const Eigen::MatrixXd& products, double left) {
  Eigen::VectorXd diagonal = products.diagonal();
  const double enough = left * diagonal.sum();
  Eigen::MatrixXd root(products.rows(), products.cols());
  long rank = 0;
  for (Eigen::Index pivot; rank < products.cols() && diagonal.sum() > enough; ++rank) {
    const double largest = diagonal.maxCoeff(&pivot);
    const auto before = root.leftCols(rank);
    root.col(rank) = (products.col(pivot) - before * before.row(pivot).transpose()) / std::sqrt(largest);
    diagonal = (diagonal - root.col(rank).cwiseAbs2()).cwiseMax(0.0);
    diagonal[pivot] = 0.0;
  }
  return root.leftCols(rank);
}

}  // namespace

// F = U S V':  basis F V = U S and mixing V' of directions above the tolerance. With F'F = L L' and L'L = W S^2 W' of
// these few columns V = L W S^-1.
Compressed Compress(const Eigen::MatrixXd& functions, double tolerance) {
  // Of squares, and a tenth of what is dropped below, so that what the columns leave off decides nothing there.
  const Eigen::MatrixXd few = LeadingColumns(ProductsOf(functions), 0.1 * tolerance * tolerance);
  if (few.cols() == 0) return {Eigen::MatrixXd(functions.rows(), 0), Eigen::MatrixXd(0, functions.cols())};
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(SelfProduct(few));
  const double least = tolerance * tolerance * eigen.eigenvalues().maxCoeff();
  const long rank = (eigen.eigenvalues().array() > least).count();
  const Eigen::VectorXd sizes = eigen.eigenvalues().tail(rank).cwiseSqrt();
  const Eigen::MatrixXd v = few * eigen.eigenvectors().rightCols(rank) * sizes.cwiseInverse().asDiagonal();
  return {TallProduct(functions, v), v.transpose()};
}

}  // namespace sagitta
