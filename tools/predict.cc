// sagitta predict: points of measurement rows from an estimate.
#include <cmath>
#include <iostream>
#include <optional>

#include "estimator/report/inspection_words.h"
#include "estimator/sagitta.h"
#include "problems/interruption.h"
#include "problems/io/output_files.h"
#include "tools/commands.h"
#include "tools/progress.h"
#include "tools/report/command_words.h"

namespace sagitta {
namespace {

int RunPredict(const CommandLine& line) {
  ExpectArguments(line, PredictCommand(), 2, 1000);
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=FILE.csv");
  const OutputFile out(FLAGS_out);
  const KnownRobot known = ReadEstimateFile(line.arguments[0]);
  // Shares as measured on 200000 rows of a UR5.
  std::optional<Progress> progress;
  progress.emplace(FLAGS_quiet, std::vector<ProgressPhase>{{"reading", 1.0}, {"predicting", 3.0}, {"writing", 2.0}});
  progress->Say("reading the rows");
  MeasurementReadOptions options;
  options.points_required = false;
  const std::vector<std::string> files(line.arguments.begin() + 1, line.arguments.end());
  Measurements rows = ReadMeasurementsFor(known.robot, files, options);
  AddKnownRotations(known, &rows);
  CheckInterruption();
  progress->Say("predicting " + std::to_string(rows.NumRows()) + " points");
  const Prediction prediction = Predict(known, rows);
  if (!FLAGS_force && !PointsAreZero(rows)) CheckReadings(known, rows, prediction.points, "--force goes on as stated");
  CheckInterruption();
  progress->Say("writing the rows");
  const std::string csv = PredictionToCsv(rows, prediction);
  const double largest = LargestDeviation(prediction, rows);  // mm
  const std::vector<std::string> warnings = WarningsOf(known, rows, prediction);
  CheckInterruption();
  out.Write(csv);
  progress.reset();
  std::cout << PredictedInWords(rows.NumRows(), largest, known.noise.freedom, FLAGS_out);
  const std::string unread = NotReadInWords(rows.unread_columns);
  if (!unread.empty()) std::cout << unread << "\n";
  for (const std::string& warning : warnings) std::cout << "Warning: " << warning << "\n";
  const std::string carried = WhatFiguresCarry(known);
  if (!carried.empty()) std::cout << carried << "\n";
  return 0;
}

}  // namespace

Command PredictCommand() {
  return {"predict",
          "points of measurement rows from an estimate, with standard deviations",
          R"(sagitta predict ESTIMATE.json MEAS.csv… --out=FILE.csv

Adds to every row (x, y, z of the rows may be absent; all in the frame of the row's station):

  pred_x_mm …                the point
  psig_x_mm …                its standard deviation from the uncertainty of the parameters, their model error
                             included (as in ci95); the noise of a measurement is not in it. What the calibration
                             could not determine (held parameters) is: where it matters, the figure is as large as that
                             parameter's possible range
  psig_distance_mm           RMS of the 3-D distance, sqrt(x² + y² + z²) of psig
  pcov_xy_mm2 …              covariances; the squares of psig are the variances
  paxis1_mm, paxis1_x …      semi-axis of the one-sigma ellipsoid and its direction, largest first; 95 % of such
                             ellipsoids hold the point when scaled by 2.80
  pheld_x_mm …               the share of held parameters in psig
  parm_x_mm …                standard deviation of where the arm stops at one arrival (repeatability); not in psig
  pnoise_x_mm …              standard deviation of one measurement (row or estimate; an instrument's range and angles
                             at the predicted point); empty: not known; not in psig
  parm_xy_mm2, pnoise_xy_mm2 …   covariances; the squares of parm and pnoise are the variances

  pred_rx_mrad …             where the target's rotation was calibrated (rows that are poses): its rotation vector
  psig_rx_urad …, parm_…, pnoise_rx_urad …   its standard deviations, of a left perturbation, as of the point

Rows with x, y, z that the robot of the estimate, where it stood, cannot have made are refused with the reason; --force
goes on. Where x, y and z of all rows are 0 they are read as absent.

The covariance of what one measurement will show is the sum of the three: psig, parm and pnoise.

Examples
  sagitta predict results/estimate.json new_poses.csv --out=predicted.csv
)",
          {"force", "out", "seed", "threads", "quiet"},
          RunPredict};
}

}  // namespace sagitta
