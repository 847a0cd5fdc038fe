// Markers of one shot on one body (mostly the flange) move together: what is left after the best rigid motion of their
// residuals is the instrument's noise alone, whatever the robot does. n markers leave 3 n - 6 degrees of freedom (two:
// one; one: none).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "problems/calibration_problem.h"
#include "problems/reading_group.h"

namespace sagitta {

// A factor on noise is another than 1 only where the interval of 95 % for it, by the likelihood ratio, does not hold 1:
// half the quantile of chi-square with one degree of freedom.
constexpr double kLeastGain = 1.92;

// Residuals of the points of one shot on one body, whitened.
struct ShotResidual {
  std::vector<int> observations;
  Eigen::VectorXd residual;
  Eigen::MatrixXd rigid;                // what small motions of the body do, 6 columns
  std::vector<Eigen::Vector3d> places;  // of each point from the instrument, m; of a rotation zero
  double turn = 0.0;                    // rad: what its points are off by, over how far they are from the base
};
std::vector<ShotResidual> ResidualsByShot(const CalibrationProblem& problem, const ParameterSet& parameters,
                                          const std::vector<int>& all);

// Orthonormal columns: what no rigid motion does.
Eigen::MatrixXd NotRigid(const ShotResidual& shot);
// What the best rigid motion leaves, and its degrees of freedom.
Eigen::VectorXd WithoutRigidMotion(const ShotResidual& shot, int* dof);

// What the shapes of the bodies cost, their marker points being estimated: 3 m - 6 each, one distance where m is 2.
int ShapeCost(const CalibrationProblem& problem);

// A group and the factor of its noise that rigid bodies show.
struct GroupOfOwnNoise {
  ScaledGroup scaled;
  double gain = 0.0;  // of log likelihood, over all readings being alike
};

// Of `groups` those that rigid bodies show to scatter otherwise than the other readings, those with the largest gains
// first. What a robot does that no model has may make the residuals of a station larger, or those along an axis; it is
// no noise of theirs.
std::vector<GroupOfOwnNoise> GroupsOfOwnNoise(const CalibrationProblem& problem, const ParameterSet& parameters,
                                              const std::vector<ReadingGroup>& groups);

}  // namespace sagitta
