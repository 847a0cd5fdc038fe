// Rows that cannot be what they say: gross outliers, and markers of one shot that fit exchanged. Judged by the
// residual of a robust linear fit at the aligned nominal robot (one reweighted Gauss-Newton step), so that neither
// the robot's own errors nor the rows themselves hide them.
#pragma once

#include <vector>

#include "estimator/inspection/finding.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {

// 3 x N residuals (predicted - measured), m, of the linearization's observations after the robust fit. noise: one
// root per observation, m, as the linearization was whitened with. step: the fit's, SI, where it is asked for.
Eigen::Matrix3Xd RobustLinearResiduals(const Linearization& linearization, const NoiseRoots& noise,
                                       Eigen::VectorXd* step = nullptr);

// Observations (positions in linearization.observations) far off the rest, or less far and alone so.
std::vector<int> GrossOutliers(const Eigen::Matrix3Xd& residuals);

std::vector<Finding> LintRows(const CalibrationProblem& problem, const Linearization& linearization,
                              const Eigen::Matrix3Xd& residuals);

}  // namespace sagitta
