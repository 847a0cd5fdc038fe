// Screening: what each candidate would explain, from the one fit.
//
// At the believed optimum the whitened residual r is orthogonal to the believed
// columns J. A candidate's columns C at neutral, projected off J,
//
//   C_perp = C - Q Q' C,   score = r' C_perp (C_perp' C_perp)^+ C_perp' r
//
// is the chi-square reduction of a linear refit, chi-square distributed with
// rank(C_perp) degrees of freedom where nothing is missing (score test).
#pragma once

#include <vector>

#include "estimator/diagnosis/candidates.h"
#include "estimator/estimate.h"
#include "estimator/linearization.h"

namespace sagitta {

struct Score {
  double reduction = 0.0;  // chi-square
  int rank = 0;
  double p_value = 1.0;    // of this test alone
  double penalised = 0.0;  // reduction - p ln(n) - 2 ln(settings)
};

// Believed columns as an orthonormal basis, and the residual.
class ProjectedResidual {
 public:
  explicit ProjectedResidual(const Linearization& believed);

  Score Test(const Eigen::MatrixXd& columns, int settings = 1) const;
  Eigen::MatrixXd ProjectOff(const Eigen::MatrixXd& columns) const;
  const Eigen::VectorXd& residual() const { return residual_; }
  // A copy that believes these columns too.
  ProjectedResidual With(const Eigen::MatrixXd& columns) const;

 private:
  ProjectedResidual() = default;
  Eigen::MatrixXd basis_;
  Eigen::VectorXd residual_;
};

Linearization LinearizeEstimate(const CalibrationProblem& problem, const ParameterSet& parameters);

// Whitened columns of a candidate at neutral, scaled to O(1).
Eigen::MatrixXd CandidateColumns(const CalibrationProblem& problem, const ParameterSet& parameters,
                                 const EffectSpec& spec);

}  // namespace sagitta
