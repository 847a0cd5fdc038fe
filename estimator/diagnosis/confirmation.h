// Does a step hold on other data? It is named and estimated again on two disjoint
// halves of the calibration configurations, and judged by cross-validation.
// Configurations with equal joint values stay together.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/step_bench.h"

namespace sagitta {

struct HalfResult {
  std::string best;        // path of the candidate that leads on this half; empty: none is worth its parameters
  bool named = false;      // the step leads, or ties with what leads, among all of sensible size that explain the same
  bool telling = false;    // the half is large enough: something is worth its parameters
  Eigen::VectorXd values;  // of the step's parameters, SI; empty where the half cannot tell them
  Eigen::MatrixXd covariance;
};

struct Confirmation {
  std::vector<HalfResult> halves;  // two
  double compatible_p = 1.0;       // of the halves' values being one, by chi-square; NaN: nothing to compare
  int folds = 0;                   // of the cross-validation
  double cv_before = 0.0;          // predicted chi-square per row of left-out configurations, without the step
  double cv_after = 0.0;           // and with it
};

// Which rows of a step bench make each half, and what does not depend on the step.
class ConfirmationBench {
 public:
  explicit ConfirmationBench(const StepBench& steps);
  // neutral_residual: StepBench::NeutralResidual of the step. tie: of the naming.
  Confirmation Confirm(const ChosenStep& step, const Eigen::VectorXd& neutral_residual, double tie) const;

 private:
  HalfResult NameAgain(const BenchPart& half, const ChosenStep& step, const Eigen::VectorXd& neutral_residual,
                       double tie) const;

  const StepBench& steps_;
  std::vector<BenchPart> halves_;
  std::vector<LinearSolution> solutions_;  // of the halves, whatever the step
  std::vector<int> fold_of_row_;           // of the cross-validation
  double cv_with_ = 0.0;                   // predicted chi-square per row of the whole model
};

}  // namespace sagitta
