// The one seam between estimation and everything that judges it: whitened
// residuals and the identification Jacobian at one point. Covariance,
// identifiability and leverage are pure functions of it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// Joint deviations are either marginalised (residuals of one visit share them:
// rows are whitened together by C = I + L L', L = d residual / d deviation times
// its sigma) or ignored (rows stay those of their observations).
enum class LatentTreatment { kMarginalise, kIgnore };

// Whitened rows at one point: residual + jacobian * (change of the coordinates).
struct Linearization {
  Eigen::VectorXd residual;       // S^-1 (predicted - measured), 3 rows per observation (a pose is two), then priors
  Eigen::MatrixXd jacobian;       // d residual / d coordinate, 1/SI; one column per entry of `columns`
  std::vector<int> columns;       // coordinate indices into ParameterSet
  std::vector<int> observations;  // index into Measurements::observations of each block of 3 rows

  Eigen::MatrixXd latent;  // L of each row; no columns where joints are exact
  bool valid = true;       // false: the equilibrium of a loaded shot diverged there

  int num_rows() const { return static_cast<int>(residual.size()); }
  int num_columns() const { return static_cast<int>(jacobian.cols()); }
};

constexpr double kFallbackSigma = 1e-3;  // m, where no noise is stated: its scale is estimated afterwards

// Rows of the listed observations, three each in their order, by visit: rows of one visit share the joints' deviations.
std::map<int, std::vector<int>> RowsByVisit(const CalibrationProblem& problem, const std::vector<int>& observations);

// Noise roots of the listed observations, m; standard deviation `fallback` (m)
// on every axis where none is stated.
NoiseRoots ObservationNoise(const CalibrationProblem& problem, const std::vector<int>& observations, double fallback);
NoiseRoots NoiseOfAll(const CalibrationProblem& problem, double fallback);

// What the fit weighs the listed observations with: the problem's weight roots where it has some, else the noise.
NoiseRoots FitRoots(const CalibrationProblem& problem, const std::vector<int>& observations, double fallback);

// measured - predicted of the listed observations, m or rad, 3 x N.
Eigen::Matrix3Xd ResidualsOf(const Measurements& data, const std::vector<int>& observations,
                             const Eigen::Matrix3Xd& predicted);

// Evaluates the problem's observations at `parameters` for the given columns.
// noise: one root per observation, m.
Linearization Linearize(const CalibrationProblem& problem, const ParameterSet& parameters,
                        const std::vector<int>& observations, const std::vector<int>& columns, const NoiseRoots& noise,
                        LatentTreatment treatment = LatentTreatment::kMarginalise);

// Adds one row per column whose coordinate has a prior, (value - prior) / sigma, and those of
// markers on the compensator's spring (spring_tie_cost.h).
void AppendPriors(const ParameterSet& parameters, Linearization* linearization);

// Predicted readings in the station frame, one column per observation: points, m, and
// rotation vectors, rad (MeasuredMinusPredicted of models/reading.h); NaN from the first
// shot on whose equilibrium diverges.
Eigen::Matrix3Xd PredictPoints(const CalibrationProblem& problem, const ParameterSet& parameters,
                               const std::vector<int>& observations);

// Least-squares solution of J x = -r and its covariance factor, with columns
// scaled to unit norm so that mixed units cannot break the rank decision.
struct LinearSolution {
  Eigen::VectorXd step;                // SI, one per column
  Eigen::MatrixXd covariance;          // (J'J)^-1, SI
  Eigen::MatrixXd covariance_root;     // W, upper triangular, with W W' = covariance
  double residual_norm_squared = 0.0;  // |J x + r|^2
  double condition = 0.0;              // of the column-normalised Jacobian
  bool full_rank = true;
};
// By QR of the rows; by their products where those are many, or columns far from depending on each other. full_rank is
// false where columns depend on each other.
LinearSolution SolveLinearization(const Linearization& linearization);

}  // namespace sagitta
