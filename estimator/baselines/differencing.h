// The papers' way with loads (000, eq. (21); 002, III.C; 003, eq. (2)): deflections are differences of loaded and
// unloaded points, and only what bends is estimated from them. A baseline, to be compared with the joint solve.
//
//   1. geometry, base poses and markers from the unloaded rows alone, compliances and compensator as the file has them
//   2. with these held, compliances and compensator from d_i = p_loaded,i - mean of the unloaded points of equal
//      configuration, visit, station and marker (weighted by their sigmas)
//
// Several loads share their unloaded mean, all markers of a visit share its joint deviations: with the rows'
// roots S and L of the deviations, the differences D p of one visit have the covariance D (S S' + L L') D'.
// The intervals of step 2 assume step 1 to be exact, as the papers do.
#pragma once

#include <functional>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// What the data do not determine must be held before (RunMethod adopts the joint decision).
Estimate EstimateByDifferencing(const CalibrationProblem& problem,
                                const std::function<void(const std::string&)>& progress = {});

}  // namespace sagitta
