// Robust losses on the whitened distance of a marker point, by iteratively
// reweighted least squares.
//
//   minimise sum_k rho(|u_k|) + sum_v |delta_v|^2 / 2,   u_k = S_k^-1 (p_k - m_k + D_k delta_v) / s
//
// One loss per marker point, not per coordinate: a reflector is read well or badly as a whole, and the
// result does not depend on how the station is turned. delta: joint deviations of
// the visit, in their standard deviations; s: robust scale.
//
//   Huber   psi = min(r, k)        w = min(1, k / r)          k = 2.1: least variance at 5 % gross errors
//   Cauchy  psi = r / (1 + (r/k)^2)   w = 1 / (1 + (r/k)^2)   k = 2.67: 95 % efficient on clean data
//
// Huber (1981), Robust Statistics; the constants are for distances in three dimensions.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/noise_report.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/loss_function.h"

namespace sagitta {

double LossWeight(LossKind loss, double distance);      // psi / r
double LossDerivative(LossKind loss, double distance);  // psi'

// What each calibration observation says, given the others.
struct PointCheck {
  std::vector<int> observations;
  std::vector<double> distance;       // |u|, joint deviations at their posterior mean
  std::vector<double> leave_one_out;  // squared Mahalanobis distance to what the others of its visit say: chi2_3
  Eigen::Matrix3Xd error;             // m, measured minus what the others say
  std::vector<double> expected;       // tr cov(u) / 3 on clean data: below 1 where deviations follow the point
};
// `noise`: roots of the calibration observations without weights; `weights` of the same.
PointCheck CheckPoints(const CalibrationProblem& problem, const ParameterSet& parameters, const NoiseRoots& noise,
                       const std::vector<double>& weights, double scale);

// Median of the squared distances over that of chi2_3: 1 where the noise is as stated, whatever a minority does.
double RobustScale(const PointCheck& check);

// Variance of the M-estimate over that of least squares on `kept` points:
//   f = [mean psi^2 / (mean (psi' + 2 psi/r) / 3)^2] / mean r^2
double LossInflation(LossKind loss, const PointCheck& check, const std::vector<bool>& kept);

// Base poses and markers by alignments that leave out what disagrees most; nominal robots are off by millimetres,
// gross errors and exchanged markers by more. Returns weights of the calibration observations to start from.
std::vector<double> AlignRobustly(const CalibrationProblem& problem, LossKind loss, ParameterSet* parameters);

}  // namespace sagitta
