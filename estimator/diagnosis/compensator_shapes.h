// Shapes of a gravity compensator. Its torque on joint j,
//
//   tau = Kc (-a L sin(gamma)) + Kc s0 (a L sin(gamma) / s),   gamma = alpha - q
//
// is linear in (Kc, Kc s0) once the shape (a / L, alpha) is given, and moves the points like a deviation k_j tau of the
// joint. So a grid of shapes stands for all; the best start the nonlinear refit. L is arbitrary (gauge) and held.
#pragma once

#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// rad. A spring carries about what the links weigh: a third of the deflection under rated load (link_gravity.cc).
constexpr double kTypicalSpringTurn = 3e-4;

// The joint's compliance in a model, or the nodes of its table.
std::vector<int> ComplianceCoordinates(const ParameterSet& parameters, const std::string& joint);
// rad/(N m); the mean of a table, 0 where there is none.
double ComplianceOf(const ParameterSet& parameters, const std::string& joint);

// The grid: gravity_compensator with L, a_x, a_y; s0 and Kc zero.
std::vector<EffectSpec> CompensatorShapes(const std::string& joint);

// Torque per unit of Kc and of Kc s0 for such a shape at each angle (rad).
Eigen::MatrixX2d TorquesPerRate(const EffectSpec& shape, const Eigen::VectorXd& angles);

// Sets s0 and Kc of a shape so that its torques are nearest to those wanted; of a spring that no machine has (negative
// rate or rest length) the nearest that one has.
void SeedSpring(const Eigen::VectorXd& angles, const Eigen::VectorXd& torques, EffectSpec* shape);

// Weak physical priors on the shape: anchors lie within metres of the joint.
void BoundCompensatorShape(ParameterSet* parameters);

}  // namespace sagitta
