// The main job: everything unknown in one solve.
//
//   1. align: base poses and markers of the nominal robot, in closed form
//   2. hold what the data do not determine there, solve jointly
//   3. decide afresh at the optimum; until nothing changes, solve again
//   4. judge: covariance, intervals, leverage, hold-out, all from one Linearization
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "estimator/estimate/estimate.h"
#include "estimator/least_squares/minimize.h"
#include "problems/calibration_problem.h"

namespace sagitta {

class RowBatches;

struct JointOptions {
  int max_iterations = 100;
  int num_threads = 1;
  CostGranularity granularity = CostGranularity::kShot;
  std::function<void(const std::string&)> progress;  // may be empty
  // Where held coordinates rest, and "before" of every table; null: the start.
  const ParameterSet* aligned = nullptr;
  bool judge = true;  // step 4; false between the rounds of an outer loop
  // Where it is asked for: the rows that were fitted, for those who judge the estimate further (FittedStream).
  std::shared_ptr<const RowBatches>* fitted = nullptr;
};
// Throws InputError that names the option (problems/range.h).
void CheckOptions(const JointOptions& options);

// All unknowns in one solve, from the aligned nominal robot. Numerical failure is a status.
Estimate EstimateJointly(const CalibrationProblem& problem, const JointOptions& options = {});

// Steps 2 to 4 from a start of one's own: base, markers and model values of
// `start` are used as they are.
Estimate EstimateFrom(const CalibrationProblem& problem, const ParameterSet& start, const JointOptions& options = {});

// Step 1 alone: "before" of every table. Returns the RMS distance, m.
double AlignNominal(const CalibrationProblem& problem, ParameterSet* parameters);

// Step 4 alone, for any method's parameters: fills the judgement of an estimate
// whose parameters, aligned, status and iterations are set.
void ComputeStatistics(const CalibrationProblem& problem, Estimate* estimate);

}  // namespace sagitta
