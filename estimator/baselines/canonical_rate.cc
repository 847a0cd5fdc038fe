#include "estimator/baselines/canonical_rate.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <vector>

namespace sagitta {
namespace {

constexpr double kRankThreshold = 1e-12;  // of column-normalised pivots: rounding of some thousand rows

Eigen::MatrixXd OrthonormalBasis(const Eigen::MatrixXd& columns) {
  const Eigen::VectorXd scale = columns.colwise().norm().cwiseMax(1e-300);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns * scale.cwiseInverse().asDiagonal());
  qr.setThreshold(kRankThreshold);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
  return qr.householderQ() * identity;
}

Eigen::MatrixXd ColumnsOfModel(const Linearization& linearization, const ParameterSet& parameters, bool of_the_model) {
  std::vector<int> chosen;
  for (int c = 0; c < linearization.num_columns(); ++c) {
    const Coordinate& coordinate = parameters.coordinates()[linearization.columns[c]];
    if ((parameters.blocks()[coordinate.block].kind == BlockKind::kModelParameter) == of_the_model) chosen.push_back(c);
  }
  Eigen::MatrixXd columns(linearization.num_rows(), chosen.size());
  for (size_t k = 0; k < chosen.size(); ++k) columns.col(k) = linearization.jacobian.col(chosen[k]);
  return columns;
}

}  // namespace

Eigen::VectorXd CanonicalCorrelations(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.cols() == 0 || b.cols() == 0) return {};
  // Cosines of the principal angles between both column spaces: singular values of Q_a' Q_b (Björck and Golub 1973).
  const Eigen::MatrixXd product = OrthonormalBasis(a).transpose() * OrthonormalBasis(b);
  if (product.size() == 0) return {};
  return Eigen::JacobiSVD<Eigen::MatrixXd>(product).singularValues();
}

double PredictTwoStepRate(const Linearization& linearization, const ParameterSet& parameters) {
  const Eigen::VectorXd cosines = CanonicalCorrelations(ColumnsOfModel(linearization, parameters, false),
                                                        ColumnsOfModel(linearization, parameters, true));
  // Alternating projections between two spaces shrink the error by cos^2 of the smallest angle a round.
  return cosines.size() == 0 ? 0.0 : cosines[0] * cosines[0];
}

}  // namespace sagitta
