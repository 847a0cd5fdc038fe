// The pose of a rigid set of markers, and how its noise follows from theirs.
#pragma once

#include "models/geometry.h"

namespace sagitta {

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Whether there are three points that are not on one line (1 mm).
bool SpansAPlane(const Eigen::Matrix3Xd& points);

// Columns (dp, dphi) -> displacements of points that move rigidly about
// `reference`: dp + dphi x (point - reference). 3N x 6.
Eigen::MatrixXd RigidColumns(const Eigen::Matrix3Xd& points, const Vector3<double>& reference);

// (dp, dphi) of the motion about `reference` that moves points onto targets; rows of
// 3N sigmas as weights, Kabsch start.
Vector6 RegisterPose(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& targets, const Eigen::VectorXd& sigmas,
                     const Vector3<double>& reference);

}  // namespace sagitta
