// Is a gravity compensator missing, and of what shape? Its torque on joint j,
//
//   tau = Kc (-a L sin(gamma)) + Kc s0 (a L sin(gamma) / s),   gamma = alpha - q
//
// is linear in (Kc, Kc s0) once the shape (a / L, alpha) is given, and moves the
// rows like a deviation k_j tau of the joint. So a grid of shapes is scanned with
// two columns each; the peaks start the nonlinear refit. L is arbitrary (gauge) and held.
#pragma once

#include <vector>

#include "estimator/diagnosis/screening.h"

namespace sagitta {

constexpr int kCompensatorParameters = 4;  // a_x, a_y, s0, Kc; L is the scale gauge

struct CompensatorShape {
  EffectSpec start;         // gravity_compensator with L, a_x, a_y, s0, Kc
  int direction = 0;        // of the anchor, on the scan's grid
  double reduction = 0.0;   // chi-square, linear; counted half where no machine has the spring
  Eigen::MatrixXd columns;  // its two, whitened
};

// The joint's compliance in a model, or the nodes of its table.
std::vector<int> ComplianceCoordinates(const ParameterSet& parameters, const std::string& joint);
// rad/(N m); the mean of a table, 0 where there is none.
double ComplianceOf(const ParameterSet& parameters, const std::string& joint);

// What a spring on one joint acts through, per row of a linearization.
struct SpringSeat {
  std::string joint;
  double compliance = 0.0;    // of the joint, rad/(N m); not above 0: no spring can act
  Eigen::VectorXd angles;     // commanded, rad
  Eigen::VectorXd deviation;  // how a deviation of the joint moves the row, whitened, per urad
};

// `deviation`: the joint's column of JointDeviationColumns.
SpringSeat SeatOf(const CalibrationProblem& problem, const ParameterSet& parameters, const std::string& joint,
                  const Eigen::VectorXd& deviation);

// Shapes of a spring that explain more than their neighbours on the grid, best first. Empty where the joint has no
// compliance.
std::vector<CompensatorShape> ScanCompensator(const SpringSeat& seat, const ProjectedResidual& residual);

// Whitened rows per unit of Kc and of Kc s0, for a spring of this shape.
Eigen::MatrixXd SpringColumns(const SpringSeat& seat, const EffectSpec& shape);

// Weak physical priors on the shape: anchors lie within metres of the joint.
void BoundCompensatorShape(ParameterSet* parameters);

}  // namespace sagitta
