// Do the intervals hold what they promise? The user's own experiment, simulated
// at its estimate with its own noise, is estimated again and again: how often the
// 95 % interval holds the truth, and the RMSE over the Cramer-Rao bound
//
//   C = (J'J)^-1 at the truth, rows whitened by the true noise.
//
// In addition to the bound, the linear generalised least squares at the truth on the same
// draws: theta + C J' r. The ratio of the two RMSE is free of the draws' luck.
#pragma once

#include <string>
#include <vector>

#include "estimator/baselines/compare_methods.h"
#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct CoverageTrial {
  int number = -1;
  std::string status;                // of the estimate
  std::vector<double> error;         // estimate - truth, SI, one per coordinate of the study; NaN: not estimated
  std::vector<double> linear_error;  // of the linear estimate on the same draw
  std::vector<double> sigma;         // reported
  std::vector<int> covered;          // 1, 0; -1: no interval
};

struct CoverageRow {
  std::string name;
  Quantity quantity = Quantity::kLength;
  int trials = 0;                                                                             // with an interval
  int covered = 0;                                                                            // of them
  double bias = 0.0, rmse = 0.0, linear_rmse = 0.0, predicted_sigma = 0.0, cramer_rao = 0.0;  // SI
  bool conditional = false;  // judged by its unconditional interval, no bound
};

class CoverageStudy {
 public:
  // truth: an estimate by `method`, `problem` with the noise that was found for it
  // (ResolvedEstimate); both must outlive the study.
  CoverageStudy(const CalibrationProblem& problem, const Estimate& truth, Method method, unsigned long long seed);

  // Coordinates studied: those the truth estimates.
  const std::vector<int>& coordinates() const { return truth_.estimated; }

  // One trial, the same on every machine. `own`: the problem as it was posed (its
  // noise is found anew in every trial), whose points and priors are overwritten;
  // one per thread.
  CoverageTrial Run(int number, CalibrationProblem* own) const;

  std::vector<CoverageRow> Summarise(const std::vector<CoverageTrial>& trials) const;

 private:
  const CalibrationProblem& problem_;
  const Estimate& truth_;
  Method method_;
  unsigned long long seed_;
  double noise_scale_;          // of the stated noise
  double fallback_;             // m, the sigma where none is stated
  Eigen::MatrixXd linear_;      // C J' at the truth
  Eigen::VectorXd cramer_rao_;  // SI, per estimated coordinate
};

}  // namespace sagitta
