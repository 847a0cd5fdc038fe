// sagitta predict: points of measurement rows from an estimate.
#include <gflags/gflags.h>

#include <filesystem>
#include <iostream>
#include <numeric>
#include <stdexcept>

#include "estimator/linearization.h"
#include "problems/input_error.h"
#include "problems/io/files.h"
#include "tools/commands.h"
#include "tools/estimate_json.h"
#include "tools/residuals_csv.h"
#include "tools/summary.h"

namespace sagitta {
namespace {

// Standard deviations of the predicted points from those of the parameters, m.
Eigen::Matrix3Xd PredictedSigmas(const CalibrationProblem& problem, const KnownRobot& known,
                                 const std::vector<int>& observations) {
  std::vector<int> columns, rows_of_covariance;
  for (size_t i = 0; i < known.uncertain.size(); ++i) {
    const int coordinate = problem.parameters.FindCoordinate(known.uncertain[i]);
    if (coordinate < 0) continue;  // a station or marker that these rows do not have
    columns.push_back(coordinate);
    rows_of_covariance.push_back(static_cast<int>(i));
  }
  const int n = static_cast<int>(columns.size());
  Eigen::MatrixXd covariance(n, n);
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) covariance(r, c) = known.covariance(rows_of_covariance[r], rows_of_covariance[c]);
  }
  const NoiseRoots ones(observations.size(), Matrix3<double>::Identity());
  const Linearization linearization =
      Linearize(problem, problem.parameters, observations, columns, ones, LatentTreatment::kIgnore);
  const Eigen::VectorXd variance =
      (linearization.jacobian * covariance).cwiseProduct(linearization.jacobian).rowwise().sum();
  const Eigen::VectorXd sigmas = variance.cwiseMax(0.0).cwiseSqrt();
  return Eigen::Map<const Eigen::Matrix3Xd>(sigmas.data(), 3, observations.size());
}

int RunPredict(const CommandLine& line) {
  ExpectArguments(line, PredictCommand(), 2, 1000);
  if (FLAGS_out.empty()) throw InputError({"", 0, "--out"}, "where to write is missing", "--out=FILE.csv");
  const KnownRobot known = ReadEstimateFile(line.arguments[0]);
  MeasurementReadOptions options;
  options.points_required = false;
  const std::vector<std::string> files(line.arguments.begin() + 1, line.arguments.end());
  const CalibrationProblem problem = PredictionProblem(known, ReadMeasurementsFor(known.robot, files, options));

  std::vector<int> all(problem.data.observations.size());
  std::iota(all.begin(), all.end(), 0);
  const Eigen::Matrix3Xd points = PredictPoints(problem, problem.parameters, all);
  if (!points.allFinite()) throw std::runtime_error("the elastic equilibrium of a loaded row diverged");
  const Eigen::Matrix3Xd sigmas = PredictedSigmas(problem, known, all);
  std::vector<AddedColumn> added = PointColumns("pred_", points);
  for (const AddedColumn& column : PointColumns("psig_", sigmas)) added.push_back(column);
  const std::string csv = RowsToCsv(problem.data, added);
  const std::filesystem::path folder = std::filesystem::path(FLAGS_out).parent_path();
  if (!folder.empty()) PrepareOutputFolder(folder.string());
  WriteTextFile(FLAGS_out, csv);
  std::cout << all.size() << " points predicted, their standard deviation at most "
            << Fixed(1e3 * (all.empty() ? 0.0 : sigmas.maxCoeff()), 4) << " mm per axis: " << FLAGS_out << "\n";
  return 0;
}

}  // namespace

Command PredictCommand() {
  return {"predict",
          "points of measurement rows from an estimate, with standard deviations",
          R"(sagitta predict ESTIMATE.json MEAS.csv… --out=FILE.csv

Adds pred_x_mm … (the point in the frame of the row's station) and psig_x_mm … (its standard deviation
from the uncertainty of the parameters; the noise of a measurement is not in it) to every row.
x, y, z of the rows may be absent.

Examples
  sagitta predict results/estimate.json new_poses.csv --out=predicted.csv
)",
          {"out", "seed", "threads", "quiet"},
          RunPredict};
}

}  // namespace sagitta
