// Laser-tracker markers and a cost of one's own in one ceres::Problem: the first marker has also touched a plane that
// is known in the station's frame. Prints the standard deviation of a marker coordinate without and with the touches.
//
// usage: plane_touch EXPERIMENT.yaml
#include <ceres/ceres.h>
#include <sagitta/sagitta.h>

#include <iostream>
#include <memory>

namespace {

// (n . p_station - d) / sigma. Blocks: base translation, base rotation (x y z w), marker, then the model's parameters.
struct PlaneTouch {
  const sagitta::CalibrationProblem* problem;
  sagitta::ShotInput shot;
  sagitta::Vector3<double> normal;
  double distance, sigma;  // m

  template <typename T>
  bool operator()(T const* const* blocks, T* residual) const {
    const Eigen::Map<const sagitta::Vector3<T>> translation(blocks[0]), marker(blocks[2]);
    const Eigen::Map<const Eigen::Quaternion<T>> rotation(blocks[1]);
    std::vector<T> theta(problem->model().num_parameters());
    for (size_t i = 0; i < theta.size(); ++i) theta[i] = blocks[3 + i][0];
    const sagitta::Vector3<T> point = problem->model().PointInStation<T>(
        shot, theta.data(), {problem->marker_frames()[0], {}, 0}, marker, rotation.toRotationMatrix(), translation);
    residual[0] = (normal.cast<T>().dot(point) - distance) / sigma;
    return true;
  }
};

void AddTouch(const sagitta::CalibrationProblem& problem, int shot, sagitta::ParameterSet* parameters,
              ceres::Problem* ceres_problem) {
  const int station = problem.data().shots[shot].station;
  std::vector<double*> blocks = {parameters->station_translation(station).values.data(),
                                 parameters->station_rotation(station).values.data(),
                                 parameters->marker(0).values.data()};
  for (int i = 0; i < parameters->num_model_parameters(); ++i)
    blocks.push_back(parameters->model_parameter(i).values.data());
  const sagitta::Vector3<double> normal = sagitta::Vector3<double>::UnitZ();
  const sagitta::Vector3<double> seen =
      problem.data().observations[problem.data().shots[shot].observations[0]].point_in_station;
  auto* cost = new ceres::DynamicAutoDiffCostFunction<PlaneTouch>(
      new PlaneTouch{&problem, problem.shot_inputs()[shot], normal, normal.dot(seen), 1e-6});
  for (size_t i = 0; i < blocks.size(); ++i) cost->AddParameterBlock(i == 1 ? 4 : i == 0 || i == 2 ? 3 : 1);
  cost->SetNumResiduals(1);
  ceres_problem->AddResidualBlock(cost, nullptr, blocks);
}

// Standard deviation of marker/<id>/z, looked up by name, after a solve with `touches` of the plane; m. The calibrated
// problem knows the noise that was found.
double SolveAndLookUp(const sagitta::Calibration& calibration, int touches) {
  const sagitta::CalibrationProblem& problem = calibration.problem;
  sagitta::ParameterSet parameters = calibration.estimate.parameters;
  ceres::Problem ceres_problem;
  sagitta::AddToProblem(problem, sagitta::CalibrationResiduals(problem), &parameters, &ceres_problem);
  for (int shot = 0; shot < touches; ++shot) AddTouch(problem, shot, &parameters, &ceres_problem);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  if (!summary.IsSolutionUsable()) return -1.0;
  // The touches read all parameters; what is fixed, held or redundant stays where it was.
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    const bool is_moved = parameters.Value(i) != calibration.estimate.parameters.Value(i);
    if (!parameters.coordinates()[i].estimated() && is_moved) return -1.0;
  }
  const int coordinate = parameters.FindCoordinate("marker/" + problem.data().markers[0] + "/z");
  const double* block = parameters.blocks()[parameters.coordinates()[coordinate].block].values.data();
  ceres::Covariance covariance({});
  if (!covariance.Compute(std::vector<const double*>{block}, &ceres_problem)) return -1.0;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> of_marker;
  covariance.GetCovarianceBlock(block, block, of_marker.data());
  return std::sqrt(of_marker(2, 2));
}

}  // namespace

int main(int, char** argv) {
  const sagitta::Calibration calibration = sagitta::Calibrate(sagitta::ReadExperiment({argv[1]}));
  if (!sagitta::IsUsable(calibration.estimate.status)) return 3;
  const double alone = SolveAndLookUp(calibration, 0), touched = SolveAndLookUp(calibration, 12);
  std::cout << 1e6 * alone << " um without, " << 1e6 * touched << " um with 12 touches\n";
  return alone > 0.0 && touched > 0.0 && touched < alone ? 0 : 1;
}
