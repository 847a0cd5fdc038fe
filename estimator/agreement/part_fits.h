// Each part of a split fitted alone, by one Gauss-Newton step from the estimate of the whole.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "estimator/agreement/base_turns.h"
#include "estimator/agreement/splits.h"
#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/part_sums.h"
#include "estimator/least_squares/row_stream.h"
#include "estimator/least_squares/row_sums.h"
#include "estimator/least_squares/sandwich.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Everything that is compared, at the estimate; without priors.
struct Whole {
  // fitted: of the problem, or null.
  Whole(const CalibrationProblem& problem, const Estimate& estimate, const FittedStream* fitted);
  Whole(const Whole&) = delete;

  const CalibrationProblem& problem;
  const Estimate& estimate;
  std::vector<int> observations;
  std::vector<int> columns;   // coordinates
  BaseTurns turns;            // which the columns of held rows and of sums have made
  std::vector<int> clusters;  // of each observation, from 0 in the order in which they appear
  bool is_scaled = false;     // the model's covariance has its scale from residuals
  bool by_sandwich = false;   // the estimate's own intervals do
  // Of each column, where repeats give the noise and nothing scales it: those of the spreads that it rests on, which
  // are the same in all parts (DofByRepeats). Empty: otherwise.
  Eigen::VectorXd dof_by_repeats;

  bool valid = false;     // false: an equilibrium diverges
  bool are_held = false;  // rows are few enough to be kept; else they come by pieces
  Linearization rows;     // where they are held
  std::optional<FittedStream> own_stream;
  const FittedStream* stream = nullptr;  // where they are not; its rows are not turned
  NormalSums sums;                       // of all, where they are many
  double squared_residual = 0.0;

  int num_columns() const { return static_cast<int>(columns.size()); }
  int num_rows() const { return 3 * static_cast<int>(observations.size()); }
};

struct PartFit {
  std::vector<int> columns;  // of the whole's
  LinearSolution solution;   // of this part
  Eigen::MatrixXd model;
  Eigen::VectorXd model_dof;
  RobustCovariance sandwich;  // where it is asked for; dof: infinite where it decides nothing
  int freedom = 0;
  bool usable = false;

  const Eigen::VectorXd& step() const { return solution.step; }  // SI
};

// Sums of both parts of every split from one pass, and those of the whole; empty where rows are few: then
// they are used as they are.
using SumsOfParts = std::vector<std::vector<NormalSums>>;
// also: or null.
SumsOfParts SumParts(const std::vector<Split>& splits, Whole* whole, AlsoSummed* also);

// Both with what either does not determine held. sums: of this split, or null.
std::array<PartFit, 2> FitParts(const Whole& whole, const Split& split, const std::vector<NormalSums>* sums);

// True where a sandwich that is `ratio` times the model's, standard deviations, is larger than chance makes it: a
// variance with nu degrees of freedom scatters by sqrt(1 / (2 nu)) of its root.
bool IsLarger(double ratio, double dof);
// That ratio, the median over all coordinates.
double RatioToModel(const Whole& whole, const RobustCovariance& sandwich);

// Fills `sandwich` of the fits of the listed splits, and returns that of the whole with its priors (no covariance: it
// cannot be solved; no degrees of freedom: it is not larger than the model's, however well it is known).
RobustCovariance AddSandwiches(const Whole& whole, const std::vector<Split>& splits, const std::vector<int>& listed,
                               std::vector<std::array<PartFit, 2>>* fits);

}  // namespace sagitta
