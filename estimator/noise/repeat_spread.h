// Noise that is read off few repeats is known only so well. Sums of m squared residuals over it are no chi-square:
// with w_k the share of the residuals that spread k with nu_k degrees of freedom divides,
//
//   T = sum_k w_k F_k,   F_k ~ F(m w_k, nu_k) independent,   mean of F_k: nu_k / (nu_k - 2),
//
// for each axis has a spread of its own. T is compared with c F(m, nu) of the same mean and variance (Box 1954):
//
//   R = var T / (mean T)^2,  nu = (4 R m + 2 m - 4) / (R m - 2),  c = mean T (nu - 2) / nu
//
// With nu_k <= 4 the variance is infinite: then c = 1 and nu = nu_k, where the above tends to.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// c and nu.
struct RatioOfSpreads {
  double factor = 1.0, dof = 0.0;
};
// Of m squares; nothing: sigmas are stated, and nu is infinite.
RatioOfSpreads RatioByRepeats(const std::optional<RepeatScatter>& repeats, double m);

// Chance of a sum of m squared whitened residuals that is larger still.
double ChanceOfSquares(const std::optional<RepeatScatter>& repeats, double squares, double m);

// The same of the residuals of a fit, m = its degrees of freedom. Where the noise was read off repeats that are fitted
// too, what they are off their means is no evidence: as the noise is theirs it is nu = sum of nu_k by construction, and
//
//   (chi^2 - nu) / (m - nu)  is compared as T of m - nu squares: what is left of the means of repeats, independent of
//   s_k
//
// 1 where means leave nothing to compare.
double ChanceOfResiduals(const CalibrationProblem& problem, double squares, double m);

// Of squared lengths of points, m, which the axis that scatters most decides:
//
//   var(sum s_k^2) = sum 2 s_k^4 / nu = 2 (sum s_k^2)^2 / dof;   infinite where sigmas are stated
double DofOfSizes(const std::optional<RepeatScatter>& repeats);
double DofOfSizes(const Vector3<double>& sigma, double dof_per_axis);

// Student's degrees of freedom of each estimated coordinate where repeats give the noise. Rotations have a variance of
// their own: with C_r = C J_r' J_r C that of C which is theirs, J_r their whitened rows,
//
//   nu = C^2 / ((C - C_r)^2 / nu_points + C_r^2 / nu_rotations)      (Satterthwaite 1946)
Eigen::VectorXd DofByRepeats(const CalibrationProblem& problem, const Estimate& estimate);

}  // namespace sagitta
