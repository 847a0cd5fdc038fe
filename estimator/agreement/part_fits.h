// Each part of a split fitted alone, by one Gauss-Newton step from the estimate of the whole.
#pragma once

#include <array>
#include <vector>

#include "estimator/agreement/splits.h"
#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/row_sums.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Everything that is compared, at the estimate.
struct Whole {
  const CalibrationProblem& problem;
  const Estimate& estimate;
  Linearization rows;         // without priors
  std::vector<int> clusters;  // of each observation
  bool is_scaled = false;     // the model's covariance takes its scale from residuals
  bool by_sandwich = false;   // the estimate's own intervals do
};

struct PartFit {
  std::vector<int> columns;  // of `Whole::rows`
  Eigen::VectorXd step;      // SI
  Eigen::MatrixXd model, sandwich;
  Eigen::VectorXd model_dof, sandwich_dof;
  int freedom = 0, clusters = 0;
  bool usable = false;
};

// Of both parts of every split; empty where rows are few: then they are taken as they are.
using SumsOfParts = std::vector<std::array<NormalSums, 2>>;
SumsOfParts SumParts(const Linearization& rows, const std::vector<Split>& splits);

// Both with what either cannot tell held. sums: of this split, or null.
std::array<PartFit, 2> FitParts(const Whole& whole, const Split& split, const std::array<NormalSums, 2>* sums,
                                bool with_sandwich);

}  // namespace sagitta
