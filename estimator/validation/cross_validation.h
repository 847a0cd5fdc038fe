// How far an estimate misses what it was not fitted to, without holding anything out: the configurations are divided
// into folds, and each fold is predicted by the fit without it,
//
//   x_f = x - (N - J_f' J_f)^-1 (g - J_f' r_f),    N = J'J and g = J'r of all rows,
//
// one Gauss-Newton step from the estimate of all rows. Whole configurations, those with equal joint values together:
// their rows share the robot's error. What is held stays held; a fold without which more would be held is calibrated
// without it, in full. The nominal robot is aligned, base poses and markers, and its alignment is a fit like another:
// its errors come by the same step of the same folds, so that both figures are of points that were not fitted. A point
// is left out whose station or marker the other folds do not determine: nothing can be predicted for it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "estimator/least_squares/part_sums.h"
#include "estimator/least_squares/row_stream.h"
#include "estimator/validation/unseen.h"

namespace sagitta {

// Points that no fold predicts, by stations or markers that their fold alone determines.
struct Unpredictable {
  int points = 0;
  std::vector<std::string> stations, markers;
};

// Both robots by the same folds.
struct CrossValidation {
  int folds = 0;         // 0: there was nothing to divide
  bool not_run = false;  // the estimate is not where the step of a fold leads from
  UnseenPoints unseen;
  UnseenPoints nominal;  // of the aligned nominal robot, on the same points; none where nothing was aligned
  Unpredictable unpredictable;
};

constexpr int kFolds = 10;  // fits of nine tenths of the rows know what they predict worse by 1 / sqrt(0.9), 5 %

// Fold of each configuration of the data (-1: it is not fitted): sorted by the hash that splits off hold-outs
// (FORMATS section 3), dealt in turn.
std::vector<int> FoldsOf(const CalibrationProblem& problem, std::uint64_t seed, int num_threads = 1);

// Which configurations go together, and what was fitted of them.
struct FoldPlan {
  std::vector<int> fold_of;  // of each configuration; -1: it is not fitted
  AlsoSummed rows;           // at the estimate: summed before, or in a pass of its own
  // False: the estimate is no minimum of the joint fit. The steps of the folds would lead to that one, and figures of
  // theirs would be those of another estimate: nothing is cross-validated.
  bool is_of_joint_fit = true;

  int count() const { return rows.partition.parts; }
};
// Nothing is summed yet.
FoldPlan PlanFolds(const CalibrationProblem& problem, const FittedStream& fitted, std::uint64_t seed);

// Of a judged estimate.
CrossValidation CrossValidate(const CalibrationProblem& problem, const FittedStream& fitted, const Estimate& estimate,
                              const FoldPlan& plan);

}  // namespace sagitta
