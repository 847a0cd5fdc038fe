// Sigmas that residuals suggest, and the weights of paper 003, eq. (14). Used by
// the weight study as printed and by calibrate.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Of a row that the fit runs through, 1 - leverage: its square then counts twenty times at most.
constexpr double kLeastFreedom = 0.05;
constexpr double kResidualFloor = 1e-7;  // m, of a residual read as a sigma: the last digit of the instrument

// w = s0 / (s0 + lambda s), paper 003 eq. (14); s0 = 0: w = 1 / s.
double Eq14Weight(double sigma0, double lambda, double sigma);

// Root mean square per group of `groups` (indices from 0), given to each of its rows, not below `floor`:
// s_g^2 = sum r^2 / sum f. freedom f: 1 per row as the paper, or 1 - leverage: what the fit leaves of each.
Eigen::VectorXd GroupSigmas(const std::vector<int>& groups, const Eigen::VectorXd& residuals,
                            const Eigen::VectorXd& freedom, double floor);

// Groups of rows by the word of the experiment file: axis, config-axis, marker-axis, station-axis or residual.
struct RowGroups {
  std::vector<int> group;          // 3 per observation of the data
  std::vector<std::string> names;  // of each group, "C7/x"
  // Of each group, where it is of one axis: what else it is of ("C7", or "" where that is all), and the axis.
  std::vector<std::string> of = {};
  std::vector<int> axes = {};
};
RowGroups GroupRows(const Measurements& data, ResidualGroup by);

// Root of every observation from the residuals of an estimate: diagonal, sigma per axis. Groups without a calibration
// row get the spread of their axis.
NoiseRoots SpreadOfResiduals(const CalibrationProblem& problem, const Estimate& estimate, const RowGroups& groups,
                             std::vector<NoiseGroup>* report);

// sigma = s0 + lambda s per axis: what eq. (14) whitens with. `spread` is diagonal.
NoiseRoots Eq14Roots(const NoiseRoots& spread, double sigma0, double lambda);

// F by which errors of an estimate are larger than those of one with the same weights, known: errors = F times those.
// With weights 1 / tau^2, tau = s0 + lambda s, that are found from the residuals of a group, s^2 = sum r^2 / nu, a
// shift of the residuals moves the weights too:
//
//   d(r_i / tau^2) / d r_j = 1/tau^2 (delta_ij - 2 (lambda s / tau) r_i r_j / (nu s^2)),  on average
//                            1/tau^2 (1 - 2 (lambda s / tau) / nu),   as E r_i r_j = s^2 delta_ij
//
//   F = (J' W (1 - 2 lambda s / (tau nu)) J)^-1 J' W J     (estimating equations: Huber 1967)
//
// problem: with the weights and the noise that were found; found: those of the groups. Of the estimated coordinates.
Eigen::MatrixXd FollowedByWeights(const CalibrationProblem& problem, const Estimate& estimate, const RowGroups& groups,
                                  const std::vector<NoiseGroup>& found);

// Puts a covariance in place of the estimate's: sigmas, intervals and weak marks follow. `dof` of each interval,
// infinite for normal ones.
void ReplaceCovariance(const CalibrationProblem& problem, const Eigen::MatrixXd& covariance, const Eigen::VectorXd& dof,
                       Estimate* estimate);

}  // namespace sagitta
