// What the rows say of the noise of groups of readings, at first order, in one more pass over the rows.
//
// With P the projection of C^-1 off the columns X that are estimated, and V the derivative of C by the logarithm of a
// factor (Harville 1977, "Maximum likelihood approaches to variance component estimation and to related problems"):
//
//   slope = 1/2 (r'P V P r - tr P V),   V = 2 M W W' M' of each reading of the group.
#include <Eigen/Cholesky>
#include <algorithm>

#include "estimator/explanations/evidence_columns.h"

namespace sagitta {
namespace {

// Of columns scaled to length 1: makes those that repeat others harmless.
constexpr double kRidge = 1e-9;

struct FittedColumns {
  Eigen::VectorXd coefficients;
  Eigen::MatrixXd covariance;
};

// From products of [X r].
FittedColumns Fit(const Eigen::MatrixXd& products) {
  const long count = products.cols() - 1;
  const Eigen::VectorXd scale = products.diagonal().head(count).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd own = scale.asDiagonal() * products.topLeftCorner(count, count) * scale.asDiagonal();
  own.diagonal().array() += kRidge;
  const Eigen::MatrixXd inverse = own.ldlt().solve(Eigen::MatrixXd::Identity(count, count));
  const Eigen::MatrixXd covariance = scale.asDiagonal() * inverse * scale.asDiagonal();
  return {covariance * products.col(count).head(count), covariance};
}

}  // namespace

// rows: C^-1 [X, r - X b] of a block. Returns P of each reading with itself, side by side.
Eigen::MatrixXd EvidenceColumns::OwnProjections(const BlockRoots& roots, const Eigen::MatrixXd& covariance,
                                                const Eigen::MatrixXd& rows) {
  Eigen::MatrixXd own(3, rows.rows());
  for (long row = 0; row < rows.rows(); row += 3) own.middleCols<3>(row).setIdentity();
  for (const PoseRoot& pose : roots) {
    const long height = pose.root.rows();
    const Eigen::MatrixXd inverse = pose.root.solve(Eigen::MatrixXd::Identity(height, height));
    for (long row = 0; row < height; row += 3) own.middleCols<3>(pose.top + row) = inverse.block<3, 3>(row, row);
  }
  for (long row = 0; row < rows.rows(); row += 3) {
    const Eigen::MatrixXd columns = rows.block(row, 0, 3, covariance.rows());
    own.middleCols<3>(row) -= columns * covariance * columns.transpose();
  }
  return own;
}

GroupScores EvidenceColumns::ScoreGroups(const RowScatter& scatter, const std::vector<int>& columns,
                                         const std::vector<ReadingGroup>& groups) const {
  const RowSums sums = Sum(scatter, columns);
  const Eigen::MatrixXd products = WithPriors(sums.products);
  const FittedColumns fitted = Fit(products);
  const long count = fitted.coefficients.size();
  const double left = products(count, count) - fitted.coefficients.dot(products.col(count).head(count));
  GroupScores scores{std::vector<FactorScore>(groups.size()),
                     {left, std::max(1.0, static_cast<double>(sums.rows - count))}};
  Block scratch;
  Eigen::MatrixXd rows;
  for (size_t b = 0; b < observations_of_block_.size(); ++b) {
    const Block& block = BlockOf(static_cast<int>(b), &scratch);
    FillRows(block, columns, &rows);
    rows.col(count) -= rows.leftCols(count) * fitted.coefficients;
    const BlockRoots roots = RootsOf(block.observations, block.here.latent, scatter);
    for (const PoseRoot& pose : roots) {
      auto own = rows.middleRows(pose.top, pose.root.rows());
      own = pose.root.solve(Eigen::MatrixXd(own));
    }
    const Eigen::MatrixXd projections = OwnProjections(roots, fitted.covariance, rows);
    for (size_t o = 0; o < block.observations.size(); ++o) {
      const long top = static_cast<long>(3 * o);
      const ReadingWithRoot reading = ReadingOf(extended_, block.observations[o]);
      const Matrix3<double> scaling = ScalingOf(reading, scatter.readings);
      for (size_t g = 0; g < groups.size(); ++g) {
        const Directions along = scaling * DirectionsOf(reading, groups[g]);
        const Eigen::MatrixXd own = along.transpose() * projections.middleCols<3>(top) * along;
        scores.of_group[g].square += (along.transpose() * rows.block<3, 1>(top, count)).squaredNorm();
        scores.of_group[g].expected += own.trace();
      }
    }
  }
  return scores;
}

}  // namespace sagitta
