// Poses to visit again: whether joints deviate at every visit, or an error follows the pose, one visit of each does not
// show. Let L be what the joints' deviations do to the n readings of a pose, whitened by the instrument's noise. What
// two visits differ by has the covariance
//
//   2 (I + L L')  where joints deviate at every visit,   2 I  where an error follows the pose,
//
// so along the eigenvectors of L L' (eigenvalues m_i) with z_i of the difference over sqrt(2):
//
//   log odds = 1/2 sum_i [ z_i^2 m_i / (1 + m_i) - log(1 + m_i) ],   z_i^2 / (1 + m_i) or z_i^2 ~ chi^2_1.
#pragma once

#include "estimator/evidence/next_poses.h"

namespace sagitta {

constexpr int kPosesAgain = 10;  // a sixth of a usual campaign

// Fitted configurations, evenly in the order of the data, and what visiting them again is expected to decide if both
// are as probable now. deviating: with the deviations of the joints that would explain the gap
// (CalibrationProblem::latent).
NextPoses ProposeRevisits(const CalibrationProblem& deviating, const ParameterSet& parameters);

}  // namespace sagitta
