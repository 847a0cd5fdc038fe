// Is a gravity compensator missing, and of what shape? Its torque on joint j,
//
//   tau = Kc (-a L sin(gamma)) + Kc s0 (a L sin(gamma) / s),   gamma = alpha - q
//
// is linear in (Kc, Kc s0) once the shape (a / L, alpha) is given, and moves the
// rows like a deviation k_j tau of the joint. So a grid of shapes is scanned with
// two columns each; the peaks start the nonlinear refit. L is free (gauge).
#pragma once

#include <vector>

#include "estimator/diagnosis/screening.h"

namespace sagitta {

struct CompensatorShape {
  EffectSpec start;         // gravity_compensator with L, a_x, a_y, s0, Kc
  int direction = 0;        // of the anchor, on the scan's grid
  double reduction = 0.0;   // chi-square, linear
  Eigen::MatrixXd columns;  // its two, whitened
};

// Shapes of a spring on `joint` that explain more than their neighbours on the grid, best first. `deviation`: the
// joint's column of JointDeviationColumns. Empty where the model has a compensator already or the joint no compliance.
std::vector<CompensatorShape> ScanCompensator(const CalibrationProblem& problem, const ParameterSet& parameters,
                                              const ProjectedResidual& residual, const Eigen::VectorXd& deviation,
                                              const std::string& joint);

// Weak physical priors on the shape: anchors lie within metres of the joint.
void BoundCompensatorShape(ParameterSet* parameters);

}  // namespace sagitta
