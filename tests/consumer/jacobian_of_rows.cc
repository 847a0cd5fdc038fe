// The identification Jacobian of rows of one's own: poses that nobody has measured. Prints which of them would make the
// parameters most certain together (D-optimality), and compares one column with differences of predicted points.
//
// usage: jacobian_of_rows EXPERIMENT.yaml
#include <sagitta/sagitta.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <numeric>

namespace {

// The first marker from the first station at joint values of one's own, rad or m. Names are those of the rows that were
// calibrated, in their order: parameters are called by them.
sagitta::Measurements RowsAt(const std::vector<Eigen::VectorXd>& poses, const sagitta::Measurements& calibrated) {
  sagitta::Measurements rows;
  rows.stations = calibrated.stations;
  rows.markers = calibrated.markers;
  for (size_t i = 0; i < poses.size(); ++i) {
    const int index = static_cast<int>(i);
    rows.configurations.push_back({"new" + std::to_string(i), poses[i], false});
    sagitta::Shot shot;
    shot.configuration = index;
    shot.station = 0;
    shot.observations = {index};
    rows.shots.push_back(shot);
    sagitta::Observation row;
    row.shot = index;
    row.marker = 0;
    row.point_in_station.setConstant(std::numeric_limits<double>::quiet_NaN());  // not measured
    rows.observations.push_back(row);
  }
  return rows;
}

std::vector<int> All(size_t count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

}  // namespace

int main(int, char** argv) {
  const sagitta::Calibration result = sagitta::Calibrate(sagitta::ReadExperiment({argv[1]}));
  if (!sagitta::IsUsable(result.estimate.status)) return 3;
  const sagitta::ParameterSet& parameters = result.estimate.parameters;
  const std::vector<int> columns = parameters.EstimatedCoordinates();

  // What the rows that were fitted know: whitened, so that the information is J'J.
  const std::vector<int> fitted = result.problem.CalibrationObservations();
  const sagitta::Linearization own =
      sagitta::Linearize(result.problem, parameters, fitted, columns,
                         sagitta::ObservationNoise(result.problem, fitted, sagitta::kFallbackSigma));
  const Eigen::VectorXd scale = own.jacobian.colwise().norm();  // of unknowns in m and rad
  const Eigen::MatrixXd scaled = own.jacobian * scale.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd covariance = (scaled.transpose() * scaled).inverse();

  // The same of rows of one's own, unweighted: d point / d parameter, m per m or rad. set_data and RenewShots trust
  // what they get: every index has to lead somewhere.
  std::vector<Eigen::VectorXd> poses;
  for (int i = 0; i < 10; ++i) {
    Eigen::VectorXd q = result.problem.data().configurations[0].q;
    for (int j = 0; j < q.size(); ++j) q[j] += 0.8 * std::sin(1.0 + 7.0 * i + 3.0 * j);
    poses.push_back(q);
  }
  sagitta::CalibrationProblem problem = result.problem;
  problem.set_data(RowsAt(poses, result.problem.data()));
  problem.RenewShots();
  const std::vector<int> rows = All(poses.size());
  const sagitta::NoiseRoots unweighted(rows.size(), sagitta::Matrix3<double>::Identity());
  const sagitta::Linearization mine =
      sagitta::Linearize(problem, parameters, rows, columns, unweighted, sagitta::LatentTreatment::kIgnore);
  if (!mine.valid) return 3;  // a load folds the arm

  // det(1 + J C J' / s^2) is by how much the determinant of the information grows.
  const double sigma = 1e-4;  // m, of the next reading
  int best = 0;
  double largest = 0.0;
  for (int i = 0; i < static_cast<int>(poses.size()); ++i) {
    const Eigen::MatrixXd j = mine.jacobian.middleRows(3 * i, 3) * scale.cwiseInverse().asDiagonal() / sigma;
    const double gain = (Eigen::Matrix3d::Identity() + j * covariance * j.transpose()).determinant();
    if (gain > largest) best = i, largest = gain;
  }
  std::cout << mine.num_rows() << " x " << mine.num_columns() << ", measure new" << best << " next\n";

  // One column from two predictions: a parameter of the model moved by h to either side.
  const double h = 1e-6;
  double off = 0.0;
  for (int c = 0; c < mine.num_columns(); ++c) {
    const sagitta::Coordinate& coordinate = parameters.coordinates()[columns[c]];
    if (coordinate.kind != sagitta::CoordinateKind::kGeometry) continue;
    Eigen::Matrix3Xd points[2];
    for (const int side : {0, 1}) {
      sagitta::ParameterSet moved = parameters;
      moved.model_parameter(parameters.blocks()[coordinate.block].owner).values[0] += side == 0 ? -h : h;
      points[side] = sagitta::PredictPoints(problem, moved, rows);
    }
    const Eigen::Matrix3Xd slope = (points[1] - points[0]) / (2.0 * h);
    off = std::max(off, (mine.jacobian.col(c) - slope.reshaped()).cwiseAbs().maxCoeff());
  }
  std::cout << "columns of the geometry differ from differences by " << off << " at most\n";
  return off < 1e-6 ? 0 : 1;
}
