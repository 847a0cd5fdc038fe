// sagitta predict: points of measurement rows from an estimate.
#include <gflags/gflags.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <iostream>

#include "estimator/results/residuals_csv.h"
#include "estimator/sagitta.h"
#include "problems/io/files.h"
#include "problems/io/output_files.h"
#include "tools/commands.h"
#include "tools/report/summary.h"

namespace sagitta {
namespace {

std::vector<AddedColumn> NumberColumns(const std::vector<std::string>& names, const Eigen::MatrixXd& values) {
  std::vector<AddedColumn> columns;
  for (size_t c = 0; c < names.size(); ++c) {
    AddedColumn column{names[c], {}};
    for (int k = 0; k < values.cols(); ++k) {
      column.cells.push_back(std::isfinite(values(c, k)) ? FormatNumber(values(c, k)) : "");
    }
    columns.push_back(std::move(column));
  }
  return columns;
}

// One point's uncertainty in mm, as the rows of the columns below.
// instrument: root of one measurement's covariance, m; NaN: not known.
Eigen::VectorXd Shares(const PredictionCovariance& point, const Matrix3<double>& instrument) {
  const Matrix3<double> mean = 1e6 * point.mean();
  const Eigen::SelfAdjointEigenSolver<Matrix3<double>> ellipsoid(mean);
  Eigen::VectorXd shares(34);
  shares.head<3>() = mean.diagonal().cwiseMax(0.0).cwiseSqrt();
  shares[3] = std::sqrt(std::max(0.0, mean.trace()));
  shares.segment<3>(4) << mean(0, 1), mean(0, 2), mean(1, 2);
  for (int i = 0; i < 3; ++i) {  // largest first
    shares[7 + 4 * i] = std::sqrt(std::max(0.0, ellipsoid.eigenvalues()[2 - i]));
    shares.segment<3>(8 + 4 * i) = ellipsoid.eigenvectors().col(2 - i);
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

std::vector<AddedColumn> UncertaintyColumns(const Measurements& rows, const Prediction& prediction, double* largest) {
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
  *largest = n == 0 ? 0.0 : values.topRows(3).maxCoeff<Eigen::PropagateNaN>();
  std::vector<AddedColumn> columns = NumberColumns(kNames, values);
  if (rows.NumRows() == static_cast<int>(n)) return columns;
  for (const AddedColumn& column : NumberColumns(kTurnNames, turns)) columns.push_back(column);
  return columns;
}

int RunPredict(const CommandLine& line) {
  ExpectArguments(line, PredictCommand(), 2, 1000);
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=FILE.csv");
  const OutputFile out(FLAGS_out);
  const KnownRobot known = ReadEstimateFile(line.arguments[0]);
  MeasurementReadOptions options;
  options.points_required = false;
  const std::vector<std::string> files(line.arguments.begin() + 1, line.arguments.end());
  Measurements rows = ReadMeasurementsFor(known.robot, files, options);
  AddKnownRotations(known, &rows);
  const Prediction prediction = Predict(known, rows);
  std::vector<AddedColumn> added = ReadingColumns("pred_", rows, prediction.points);
  double largest = 0.0;  // mm
  for (const AddedColumn& column : UncertaintyColumns(rows, prediction, &largest)) added.push_back(column);
  const std::string csv = RowsToCsv(rows, added);
  out.Write(csv);
  const std::string deviation =
      std::isfinite(largest) ? "at most " + Fixed(largest, 4) + " mm per axis" : "not known: no rows to spare told it";
  std::cout << rows.NumRows() << " points predicted, their standard deviation " << deviation << ": " << FLAGS_out
            << "\n";
  const std::string model_error = ModelErrorInWords(known);
  if (!model_error.empty()) std::cout << model_error << "\n";
  return 0;
}

}  // namespace

Command PredictCommand() {
  return {"predict",
          "points of measurement rows from an estimate, with standard deviations",
          R"(sagitta predict ESTIMATE.json MEAS.csv… --out=FILE.csv

Adds to every row (x, y, z of the rows may be absent; all in the frame of the row's station):

  pred_x_mm …                the point
  psig_x_mm …                its standard deviation from the uncertainty of the parameters; the noise of a
                             measurement is not in it. What the calibration could not tell (held parameters) is:
                             where it matters, the figure is as large as that parameter's possible range
  psig_distance_mm           RMS of the 3-D distance, sqrt(x² + y² + z²) of psig
  pcov_xy_mm2 …              covariances beside the squares of psig
  paxis1_mm, paxis1_x …      semi-axis of the one-sigma ellipsoid and its direction, largest first; 95 % of such
                             ellipsoids hold the point when scaled by 2.80
  pheld_x_mm …               the share of held parameters in psig
  parm_x_mm …                standard deviation of where the arm stops at one arrival (repeatability); not in psig
  pnoise_x_mm …              standard deviation of one measurement (row or estimate; an instrument's range and angles
                             at the predicted point); empty: not known; not in psig
  parm_xy_mm2, pnoise_xy_mm2 …   covariances beside the squares of parm and pnoise

  pred_rx_mrad …             where the target's rotation was calibrated (rows that are poses): its rotation vector
  psig_rx_urad …, parm_…, pnoise_rx_urad …   its standard deviations, of a left perturbation, as of the point

The covariance of what one measurement will show is the sum of the three: psig, parm and pnoise.

Examples
  sagitta predict results/estimate.json new_poses.csv --out=predicted.csv
)",
          {"out", "seed", "threads", "quiet"},
          RunPredict};
}

}  // namespace sagitta
