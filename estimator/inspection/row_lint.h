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

// What the lengths of residuals of a robust fit of `unknowns` are measured by. Such a fit passes through as many rows
// as it has unknowns for, three to a row: these lie within nearly nothing and say nothing of the noise. The median of
// the others (Holland, Welsch, Robust regression using iteratively reweighted least-squares, Communications in
// Statistics A 6 (1977) 813; Street, Carroll, Ruppert, A note on computing robust regression estimates via iteratively
// reweighted least squares, The American Statistician 42 (1988) 152). No others: infinity.
double TypicalDistance(std::vector<double> distances, int unknowns);

// Observations (positions in linearization.observations) far off the rest, or less far and alone so. unknowns: of the
// fit that left the residuals.
std::vector<int> GrossOutliers(const Eigen::Matrix3Xd& residuals, int unknowns);

std::vector<Finding> LintRows(const CalibrationProblem& problem, const Linearization& linearization,
                              const Eigen::Matrix3Xd& residuals);

}  // namespace sagitta
