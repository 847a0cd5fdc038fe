// Calibration from full poses, approach #1 of paper 000, section IV, as a
// comparison: every shot's position and orientation come from its markers by rigid
// registration, then least squares on both,
//
//   sum over shots  |dp|^2 + w^2 |dphi|^2      w: normalisation, m/rad
//
// or, with the propagated 6x6 covariance C of each pose, sum (dp, dphi)' C^-1
// (dp, dphi). The second is generalised least squares on a sufficient statistic: to
// first order it is least squares on the marker coordinates (approach #2), given
// the shape of the marker set.
//
// The pose needs the marker points on the flange:
// * markers fixed (estimate.markers: false): the points the experiment states;
// * markers free: their shape from all shots by generalised Procrustes (no robot
//   model enters), started at the aligned estimate; the tool's place on the flange
//   (6 unknowns) is estimated along with base and geometry.
// Shots with fewer than three markers, or with markers on one line, have no pose
// and are left out. Rows with unequal sigmas: the registration is weighted.
// What the data do not determine must be held before, as in two_step.h.
#pragma once

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct FullPoseOptions {
  double weight = 0.3;                                            // m/rad; 0.3 comes nearest to paper 000, Table I
  bool propagated_covariance = false;                             // C^-1 in place of (1, w^2)
  Vector3<double> reference_in_flange = Vector3<double>::Zero();  // m, the point whose position counts
  int max_iterations = 50;
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const FullPoseOptions& options);

// Standard deviations are those of this method (sandwich where w is not optimal);
// the marker shape counts as known. Trouble: a status with words.
Estimate EstimateFromFullPoses(const CalibrationProblem& problem, const FullPoseOptions& options = {});

}  // namespace sagitta
