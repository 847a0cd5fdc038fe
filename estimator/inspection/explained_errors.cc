#include "estimator/inspection/explained_errors.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/alignment/starting_values.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {
namespace {

constexpr double kPrecision = 5e-4;  // of the reach, per coordinate: a tenth of what is suspicious
constexpr double kAnywhere = 10.0;   // m, rad: base and markers are not bound
constexpr int kMostSteps = 30;
constexpr int kMostHalvings = 10;
constexpr double kSettled = 1e-6;  // relative gain of the objective

struct Unknowns {
  std::vector<int> columns;
  Eigen::VectorXd size;  // SI
  std::vector<bool> is_error;
};

Unknowns UnknownsOf(const CalibrationProblem& problem) {
  Unknowns unknowns;
  std::vector<double> size;
  const ParameterSet& parameters = problem.parameters;
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    const Coordinate& coordinate = parameters.coordinates()[i];
    const ParameterBlock& block = parameters.blocks()[coordinate.block];
    const bool is_model = block.kind == BlockKind::kModelParameter;
    const bool is_error = is_model && problem.model.parameters()[block.owner].law == ParameterLaw::kGeometry;
    if (is_model ? !is_error : !coordinate.free) continue;
    unknowns.columns.push_back(i);
    unknowns.is_error.push_back(is_error);
    const bool is_length = coordinate.quantity == Quantity::kLength;
    size.push_back(!is_error ? kAnywhere : is_length ? kErrorLength : kErrorAngle);
  }
  unknowns.size = Eigen::Map<Eigen::VectorXd>(size.data(), static_cast<Eigen::Index>(size.size()));
  return unknowns;
}

// Errors in units of their size; 0 for base and markers.
Eigen::VectorXd Errors(const CalibrationProblem& problem, const Unknowns& unknowns, const ParameterSet& parameters) {
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(unknowns.size.size());
  for (int c = 0; c < errors.size(); ++c) {
    if (!unknowns.is_error[c]) continue;
    const int i = unknowns.columns[c];
    errors[c] = (parameters.Value(i) - problem.parameters.Value(i)) / unknowns.size[c];
  }
  return errors;
}

}  // namespace

ExplainedErrors ExplainByErrors(const CalibrationProblem& problem, const std::vector<int>& readings) {
  const std::vector<int> rows = problem.data.PointsAmong(readings);
  const Unknowns unknowns = UnknownsOf(problem);
  ParameterSet parameters = problem.parameters;
  ExplainedErrors found;
  found.left = FindStartingValues(problem, readings, StartingValueOptions(), &parameters);
  const double precision = kPrecision * Reach(problem.robot.chain);
  if (unknowns.columns.empty() || !(precision > 0.0)) return found;
  const NoiseRoots noise(rows.size(), precision * Matrix3<double>::Identity());
  const auto linearize = [&](const ParameterSet& at) {
    return Linearize(problem, at, rows, unknowns.columns, noise, LatentTreatment::kIgnore);
  };
  Linearization here = linearize(parameters);
  if (!here.valid) return found;
  Eigen::VectorXd errors = Errors(problem, unknowns, parameters);
  double objective = here.residual.squaredNorm() + errors.squaredNorm();
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::MatrixXd jacobian = here.jacobian * unknowns.size.asDiagonal();
    const Eigen::MatrixXd normal =
        jacobian.transpose() * jacobian + Eigen::MatrixXd::Identity(jacobian.cols(), jacobian.cols());
    const Eigen::VectorXd gradient = jacobian.transpose() * here.residual + errors;
    const Eigen::VectorXd move = -unknowns.size.cwiseProduct(normal.llt().solve(gradient));
    const double before = objective;
    double share = 1.0;
    for (int halving = 0; halving < kMostHalvings; ++halving, share *= 0.5) {
      Eigen::VectorXd delta = Eigen::VectorXd::Zero(parameters.num_coordinates());
      for (int c = 0; c < move.size(); ++c) delta[unknowns.columns[c]] = share * move[c];
      ParameterSet next = parameters;
      next.Plus(delta);
      const Linearization there = linearize(next);
      const Eigen::VectorXd own = Errors(problem, unknowns, next);
      const double value = there.valid ? there.residual.squaredNorm() + own.squaredNorm() : INFINITY;
      if (!(value < objective)) continue;
      parameters = next;
      here = there;
      errors = own;
      objective = value;
      break;
    }
    if (before - objective <= kSettled * before) break;
  }
  found.left = precision * here.residual.norm() / std::sqrt(static_cast<double>(rows.size()));
  int largest = 0;
  found.relative = errors.cwiseAbs().maxCoeff(&largest);
  const Coordinate& coordinate = parameters.coordinates()[unknowns.columns[largest]];
  found.largest = coordinate.name;
  found.quantity = coordinate.quantity;
  found.value = errors[largest] * unknowns.size[largest];
  return found;
}

}  // namespace sagitta
