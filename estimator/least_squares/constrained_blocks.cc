#include "estimator/least_squares/constrained_blocks.h"

#include <ceres/manifold.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "estimator/least_squares/rotation_manifold.h"

namespace sagitta {
namespace {

// Holds what is not estimated: whole blocks, or single coordinates.
void ConstrainBlock(const ParameterSet& parameters, const ParameterBlock& block, double* values,
                    ceres::Problem* ceres_problem) {
  std::vector<int> estimated;
  std::vector<int> held;
  for (int i = 0; i < block.tangent_size; ++i) {
    (parameters.coordinates()[block.first_coordinate + i].estimated() ? estimated : held).push_back(i);
  }
  if (estimated.empty()) {
    ceres_problem->SetParameterBlockConstant(values);
  } else if (IsRotation(block.kind)) {
    ceres_problem->SetManifold(values, new RotationManifold(estimated));
  } else if (!held.empty()) {
    ceres_problem->SetManifold(values, new ceres::SubsetManifold(block.tangent_size, held));
  }
  if (estimated.empty()) return;
  for (const int i : estimated) {
    const double lower = parameters.coordinates()[block.first_coordinate + i].lower;
    if (std::isfinite(lower)) ceres_problem->SetParameterLowerBound(values, i, lower);
  }
}

}  // namespace

void ConstrainBlocks(const ParameterSet& parameters, ceres::Problem* ceres_problem) {
  for (const ParameterBlock& block : parameters.blocks()) {
    double* values = const_cast<double*>(block.values.data());
    if (ceres_problem->HasParameterBlock(values)) ConstrainBlock(parameters, block, values, ceres_problem);
  }
}

void AddHeldBlocks(const ParameterSet& parameters, ceres::Problem* ceres_problem) {
  for (const Coordinate& coordinate : parameters.coordinates()) {
    if (coordinate.estimated()) continue;
    const std::vector<double>& values = parameters.blocks()[coordinate.block].values;
    ceres_problem->AddParameterBlock(const_cast<double*>(values.data()), static_cast<int>(values.size()));
  }
}

void RemoveBounds(const ParameterSet& parameters, ceres::Problem* problem) {
  for (const Coordinate& coordinate : parameters.coordinates()) {
    double* values = const_cast<double*>(parameters.blocks()[coordinate.block].values.data());
    if (!coordinate.estimated() || !std::isfinite(coordinate.lower) || !problem->HasParameterBlock(values)) continue;
    problem->SetParameterLowerBound(values, coordinate.index_in_block, -std::numeric_limits<double>::max());
  }
}

bool IsInside(const ParameterSet& parameters) {
  const std::vector<int> estimated = parameters.EstimatedCoordinates();
  return std::all_of(estimated.begin(), estimated.end(),
                     [&](int i) { return parameters.Value(i) >= parameters.coordinates()[i].lower; });
}

}  // namespace sagitta
