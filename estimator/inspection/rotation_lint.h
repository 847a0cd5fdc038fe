// Rotations that are written in another way than their columns say, next to points that fit: a product of rotations
// about the axes in place of a rotation vector, the inverse, another unit, the scalar of a quaternion last.
//
// Base poses are aligned to the points alone. With the nominal frame F_k that a target T rides on, a rotation read at
// station s is R_k = R_s F_k T; the reading is the one that misses least, T fitted (aligned_misfit.h).
#pragma once

#include <optional>

#include "estimator/inspection/finding.h"
#include "models/constants.h"
#include "problems/calibration_problem.h"

namespace sagitta {

constexpr double kRotationFits = 5.0 * kDegree;  // nominal robots turn their flange by far less than this wrongly

// Nothing where no rotation is read, where they fit, where the points do not fit or cannot determine the rotation of
// their base.
std::optional<Finding> LintRotations(const CalibrationProblem& problem);

}  // namespace sagitta
