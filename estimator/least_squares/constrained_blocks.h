// What is not estimated does not move: manifolds, bounds and constant blocks of a ceres::Problem on the memory of a
// ParameterSet.
#pragma once

#include <ceres/problem.h>

#include "problems/parameter_set.h"

namespace sagitta {

// Of every block that the problem has: whole blocks or single coordinates are held, lower bounds are set.
void ConstrainBlocks(const ParameterSet& parameters, ceres::Problem* ceres_problem);

// Adds every block that has a coordinate which is not estimated: whatever is added later and reads it, ConstrainBlocks
// holds it.
void AddHeldBlocks(const ParameterSet& parameters, ceres::Problem* ceres_problem);

void RemoveBounds(const ParameterSet& parameters, ceres::Problem* ceres_problem);

// Whether all that is estimated lies above its bound.
bool IsInside(const ParameterSet& parameters);

}  // namespace sagitta
