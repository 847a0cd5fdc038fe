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
// Rest length s0 in units of a. A tension spring is never slack and is stretched to twice its rest length at most:
// (a + L) / 2 <= s0 <= a - L, which for the KR 270's a / L = 3.7 is 0.63 to 0.73 a (published: 458 of 686 mm, 0.67).
// Gas springs have any equivalent rest length up to a.
constexpr double kUsualRest = 0.65, kRestDeviation = 0.25;

// Whether it is where a spring is and how long, in which its torque is not linear; its rate is none of these.
bool IsSpringShape(const Coordinate& coordinate);

// Whether the robot has no spring and this would be one: that of the robot has its values there.
inline bool IsNewSpring(const EffectSpec& spec) { return IsGravityCompensator(spec) && !spec.values.empty(); }

// Of a spring that the robot states: coordinates that are held, but for L (the gauge), and what they may be off by.
std::vector<int> HeldSpring(const ParameterSet& parameters);
double TypicalSpringError(const ParameterSet& parameters, int coordinate);
// Those free, with priors of so many typical errors about the stated values. rate_alone: where it is stated to be.
void FreeSpring(bool rate_alone, double prior_scale, ParameterSet* parameters);

// The joint's compliance in a model, or the nodes of its table.
std::vector<int> ComplianceCoordinates(const ParameterSet& parameters, const std::string& joint);
// rad/(N m); the mean of a table, 0 where there is none.
double ComplianceOf(const ParameterSet& parameters, const std::string& joint);

// The effect that a joint gives way, where the robot does not state that it does.
EffectSpec ComplianceEffectOf(const std::string& joint);

// The grid: gravity_compensator with L, a_x, a_y; s0 and Kc zero.
std::vector<EffectSpec> CompensatorShapes(const std::string& joint);

// Joint torques of a spring of this shape at each angle (cosine and sine), in an arbitrary unit: with the usual rest
// length; what another rest length adds per standard deviation; and other directions and ratios within the grid's cell.
Eigen::MatrixXd SpringColumns(const EffectSpec& shape, const Eigen::MatrixX2d& wave);

// N m at each angle (rad, commanded), of the spring that a model has.
Eigen::VectorXd SpringTorques(const ParameterSet& parameters, const Eigen::VectorXd& angles);

// How probable a spring on a joint is before any row is seen, by its torque: a compensator is built where weight is
// carried, and against it. With w the torque that a weight at the flange puts on the joint,
//
//   share = elsewhere + per_cosine cos^2(torque, w) where the cosine is negative, else elsewhere
//
// A coefficient of columns has either sign, and a spring that is shorter than its rest length pushes: which way it acts
// is known once it is fitted.
struct SpringShares {
  Eigen::VectorXd of_weight;  // w at some shots, m
  double per_cosine = 0.0, elsewhere = 0.0;

  // torques: at these shots.
  double Of(const Eigen::VectorXd& torques) const;
};

// Sets s0 and Kc of a shape so that its torques are nearest to those wanted; of a spring that no machine has (negative
// rate or rest length) the nearest that one has.
void SeedSpring(const Eigen::VectorXd& angles, const Eigen::VectorXd& torques, EffectSpec* shape);

// What is known of the rest length of a spring, over what the columns' coefficients say of it (SpringColumns: c_0 and
// c_1 normal and independent make x = c_1 / c_0 Cauchy), with x = (s0 / max(a, L) - usual) / deviation:
//   log N(x; 0, 1) - log (1 / (pi (1 + x^2)))
// -infinity of a spring that is shorter at some angle than a tenth of the longer lever: no machine has one.
double LogPriorOfSpring(const ParameterSet& parameters);

// Weak physical priors on the shape: anchors lie within metres of the joint. keep: near the shape as it is, and the
// rest length that goes with it.
void BoundCompensatorShape(bool keep, ParameterSet* parameters);

}  // namespace sagitta
