// The rows of `sagitta predict`: input columns, points, and what their uncertainty is made of.
#include <cmath>

#include "estimator/results/residuals_csv.h"
#include "estimator/sagitta.h"
#include "models/matrix_functions.h"

namespace sagitta {
namespace {

std::vector<AddedColumn> NumberColumns(const std::vector<std::string>& names, const Eigen::MatrixXd& values) {
  std::vector<AddedColumn> columns;
  for (size_t c = 0; c < names.size(); ++c) {
    AddedColumn column{names[c], {}};
    for (int k = 0; k < values.cols(); ++k) column.numbers.push_back(values(static_cast<Eigen::Index>(c), k));
    columns.push_back(std::move(column));
  }
  return columns;
}

// One point's uncertainty in mm, as the rows of the columns below.
// instrument: root of one measurement's covariance, m; NaN: not known.
Eigen::VectorXd Shares(const PredictionCovariance& point, const Matrix3<double>& instrument) {
  const Matrix3<double> mean = 1e6 * point.mean();
  const PrincipalAxes ellipsoid = PrincipalAxesOf(mean);
  Eigen::VectorXd shares(34);
  shares.head<3>() = mean.diagonal().cwiseMax(0.0).cwiseSqrt();
  shares[3] = std::sqrt(std::max(0.0, mean.trace()));
  shares.segment<3>(4) << mean(0, 1), mean(0, 2), mean(1, 2);
  for (int i = 0; i < 3; ++i) {  // largest first
    shares[7 + 4 * i] = std::sqrt(std::max(0.0, ellipsoid.values[2 - i]));
    shares.segment<3>(8 + 4 * i) = ellipsoid.axes.col(2 - i);
  }
  shares.segment<3>(19) = 1e3 * point.held.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Matrix3<double> arm = 1e6 * point.arm, noise = 1e6 * instrument * instrument.transpose();
  shares.segment<3>(22) = arm.diagonal().cwiseSqrt();
  shares.segment<3>(25) = noise.diagonal().cwiseSqrt();
  shares.segment<6>(28) << arm(0, 1), arm(0, 2), arm(1, 2), noise(0, 1), noise(0, 2), noise(1, 2);
  return shares;
}

// The same of a rotation, urad: standard deviations of the mean, the arm and one measurement.
Eigen::VectorXd TurnShares(const PredictionCovariance& rotation, const Matrix3<double>& instrument) {
  Eigen::VectorXd shares(9);
  shares << rotation.mean().diagonal(), rotation.arm.diagonal(), (instrument * instrument.transpose()).diagonal();
  return 1e6 * shares.cwiseMax(0.0).cwiseSqrt();
}

std::vector<AddedColumn> UncertaintyColumns(const Measurements& rows, const Prediction& prediction) {
  static const std::vector<std::string> kNames = {
      "psig_x_mm",   "psig_y_mm",   "psig_z_mm",   "psig_distance_mm", "pcov_xy_mm2",   "pcov_xz_mm2",  "pcov_yz_mm2",
      "paxis1_mm",   "paxis1_x",    "paxis1_y",    "paxis1_z",         "paxis2_mm",     "paxis2_x",     "paxis2_y",
      "paxis2_z",    "paxis3_mm",   "paxis3_x",    "paxis3_y",         "paxis3_z",      "pheld_x_mm",   "pheld_y_mm",
      "pheld_z_mm",  "parm_x_mm",   "parm_y_mm",   "parm_z_mm",        "pnoise_x_mm",   "pnoise_y_mm",  "pnoise_z_mm",
      "parm_xy_mm2", "parm_xz_mm2", "parm_yz_mm2", "pnoise_xy_mm2",    "pnoise_xz_mm2", "pnoise_yz_mm2"};
  const size_t n = prediction.covariances.size();
  static const std::vector<std::string> kTurnNames = {"psig_rx_urad",   "psig_ry_urad",   "psig_rz_urad",
                                                      "parm_rx_urad",   "parm_ry_urad",   "parm_rz_urad",
                                                      "pnoise_rx_urad", "pnoise_ry_urad", "pnoise_rz_urad"};
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(kNames.size(), n);
  Eigen::MatrixXd turns = Eigen::MatrixXd::Constant(kTurnNames.size(), n, std::nan(""));  // in their points' columns
  for (size_t k = 0; k < n; ++k) {
    Matrix3<double> instrument = prediction.instrument[k];
    if (!IsStated(instrument)) instrument.setConstant(std::nan(""));
    if (rows.observations[k].is_point()) {
      values.col(k) = Shares(prediction.covariances[k], instrument);
    } else {
      turns.col(rows.observations[k].partner) = TurnShares(prediction.covariances[k], instrument);
    }
  }
  std::vector<AddedColumn> columns = NumberColumns(kNames, values);
  if (rows.NumRows() == static_cast<int>(n)) return columns;
  for (const AddedColumn& column : NumberColumns(kTurnNames, turns)) columns.push_back(column);
  return columns;
}

}  // namespace

std::string PredictionToCsv(const Measurements& rows, const Prediction& prediction) {
  CheckAreOf(rows, prediction.covariances.size(), "PredictionToCsv");
  std::vector<AddedColumn> added = ReadingColumns("pred_", rows, prediction.points);
  for (const AddedColumn& column : UncertaintyColumns(rows, prediction)) added.push_back(column);
  return RowsToCsv(rows, added);
}

double LargestDeviation(const Prediction& prediction, const Measurements& rows) {
  CheckAreOf(rows, prediction.covariances.size(), "LargestDeviation");
  double largest = 0.0;
  for (size_t k = 0; k < prediction.covariances.size(); ++k) {
    if (!rows.observations[k].is_point()) continue;
    const double variance = prediction.covariances[k].mean().diagonal().maxCoeff<Eigen::PropagateNaN>();
    if (!std::isfinite(variance)) return variance;
    largest = std::max(largest, variance);
  }
  return 1e3 * std::sqrt(largest);
}

}  // namespace sagitta
