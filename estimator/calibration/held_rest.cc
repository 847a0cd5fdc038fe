#include "estimator/calibration/held_rest.h"

#include <algorithm>
#include <cmath>

#include "estimator/least_squares/held_influence.h"
#include "models/gravity_compensator.h"

namespace sagitta {
namespace {

// Of a column's norm: below it normal equations lose the prior in rounding.
constexpr double kLeastWeight = 1e-6;
constexpr double kUnmoved = 1e-6;  // of the range: rounding along what no row sees

double ColumnNorm(const Linearization& rows, int coordinate) {
  const auto column = std::find(rows.columns.begin(), rows.columns.end(), coordinate);
  return column == rows.columns.end() ? 0.0 : rows.jacobian.col(column - rows.columns.begin()).norm();
}

}  // namespace

double ReferenceOf(const CalibrationProblem& problem, const ParameterSet& aligned, int coordinate) {
  const ParameterBlock& block = aligned.blocks()[aligned.coordinates()[coordinate].block];
  return (block.kind == BlockKind::kStationTranslation ? aligned : problem.parameters).Value(coordinate);
}

ParameterSet ReleaseHeld(const CalibrationProblem& problem, const ParameterSet& parameters, const ParameterSet& aligned,
                         const Linearization& here, double noise_scale) {
  ParameterSet released = parameters;
  for (const int i : HeldCoordinates(parameters)) {
    Coordinate& coordinate = released.coordinate(i);
    // The scale of a spring's triangle moves no point (gravity_compensator.h): its length is as stated.
    if (IsRotation(released.blocks()[coordinate.block].kind) || coordinate.name == NameOf(CompensatorPart::kL))
      continue;
    coordinate.held = false;
    if (coordinate.has_prior()) continue;
    // s / P in whitened rows: the prior of the header.
    const double weight = std::max(noise_scale / PhysicalRange(coordinate), kLeastWeight * ColumnNorm(here, i));
    coordinate.prior_sigma = 1.0 / weight;
    coordinate.prior_value = ReferenceOf(problem, aligned, i);
  }
  return released;
}

ParameterSet HoldAgain(const ParameterSet& parameters, const ParameterSet& released) {
  ParameterSet held = released;
  Eigen::VectorXd back = Eigen::VectorXd::Zero(held.num_coordinates());
  for (int i = 0; i < held.num_coordinates(); ++i) {
    const Coordinate &before = parameters.coordinates()[i], &now = released.coordinates()[i];
    held.coordinate(i) = before;
    const double moved = released.Value(i) - now.prior_value;
    if (before.held && !now.held && std::abs(moved) < kUnmoved * PhysicalRange(before)) back[i] = -moved;
  }
  held.Plus(back);
  return held;
}

}  // namespace sagitta
