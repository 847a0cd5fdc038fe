#include "estimator/inspection/explained_errors.h"

#include <cmath>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/alignment/starting_values.h"
#include "estimator/least_squares/gauss_newton.h"

namespace sagitta {
namespace {

constexpr double kPrecision = 5e-4;    // of the reach, per coordinate: a tenth of what is suspicious
constexpr double kAnywhere = 10.0;     // m, rad: base and markers are not bound
constexpr double kSettledStep = 0.01;  // standard deviations left: a hundredth of the precision

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
    const bool is_error = is_model && problem.model().parameters()[block.owner].law == ParameterLaw::kGeometry;
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
Eigen::VectorXd ErrorsAt(const CalibrationProblem& problem, const Unknowns& unknowns, const ParameterSet& parameters) {
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(unknowns.size.size());
  for (int c = 0; c < errors.size(); ++c) {
    if (!unknowns.is_error[c]) continue;
    const int i = unknowns.columns[c];
    errors[c] = (parameters.Value(i) - problem.parameters.Value(i)) / unknowns.size[c];
  }
  return errors;
}

// One row per unknown: errors are of their size; base and markers are only kept from steps beyond theirs.
void AppendSizes(const Unknowns& unknowns, const Eigen::VectorXd& errors, Linearization* here) {
  const Eigen::Index rows = here->residual.size(), n = unknowns.size.size();
  here->residual.conservativeResize(rows + n);
  here->residual.tail(n) = errors;
  here->jacobian.conservativeResize(rows + n, Eigen::NoChange);
  here->jacobian.bottomRows(n) = unknowns.size.cwiseInverse().asDiagonal();
}

}  // namespace

ExplainedErrors ExplainByErrors(const CalibrationProblem& problem, const std::vector<int>& readings) {
  const std::vector<int> rows = problem.data().PointsAmong(readings);
  const Unknowns unknowns = UnknownsOf(problem);
  ParameterSet parameters = problem.parameters;
  ExplainedErrors found;
  found.left = FindStartingValues(problem, readings, &parameters);
  const double precision = kPrecision * Reach(problem);
  if (unknowns.columns.empty() || !(precision > 0.0)) return found;
  const NoiseRoots noise(rows.size(), precision * Matrix3<double>::Identity());
  const auto rows_at = [&](const ParameterSet& at, const std::vector<int>& columns) -> FittedRows {
    Linearization here = Linearize(problem, at, rows, columns, noise, LatentTreatment::kIgnore);
    if (here.valid) AppendSizes(unknowns, ErrorsAt(problem, unknowns, at), &here);
    return {here, here.num_rows()};
  };
  GaussNewtonOptions options;
  options.tolerance = kSettledStep;
  const GaussNewtonResult fit = GaussNewton(rows_at, unknowns.columns, parameters, options);
  if (!fit.fitted.rows.valid) return found;
  const auto readings_only = static_cast<Eigen::Index>(3 * rows.size());
  found.left =
      precision * fit.fitted.rows.residual.head(readings_only).norm() / std::sqrt(static_cast<double>(rows.size()));
  const Eigen::VectorXd errors = ErrorsAt(problem, unknowns, fit.parameters);
  int largest = 0;
  found.relative = errors.cwiseAbs().maxCoeff(&largest);
  const Coordinate& coordinate = fit.parameters.coordinates()[unknowns.columns[largest]];
  found.largest = coordinate.name;
  found.quantity = coordinate.quantity;
  found.value = errors[largest] * unknowns.size[largest];
  return found;
}

}  // namespace sagitta
