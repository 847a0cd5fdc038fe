// The gap to somebody else's simulation (columns sim_x_mm, sim_y_mm, sim_z_mm).
//
// The diagnosis explains measured - model. With y' = measured - simulated + f,
// f our nominal model with base and markers aligned to the simulated points, it
// explains measured - simulated by the same effects: what our nominal kinematics
// cannot reproduce of the simulation cancels.
#pragma once

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct SimulationBaseline {
  CalibrationProblem problem;  // its points are y'; base and markers start aligned
  Eigen::Matrix3Xd shift;      // m, y' - measured, per row
  double reproduced = 0.0;     // m, RMS distance of the simulated points from our nominal model

  // Points and predictions of an extended problem as they were measured: predicted is then simulated + corrections.
  void Unshift(CalibrationProblem* extended, Estimate* estimate) const;
};

// `problem`: built with only base and markers free, unless its author said more.
// Throws InputError where a row states no simulated point.
SimulationBaseline AgainstSimulation(const CalibrationProblem& problem);

}  // namespace sagitta
