// Does a step hold on other data? It is named and estimated again on two disjoint
// halves of the calibration configurations, and judged by cross-validation.
// Configurations with equal joint values stay together.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/selection.h"

namespace sagitta {

struct HalfResult {
  std::string best;        // path of the candidate that leads on this half; empty: none is worth its parameters
  bool named = false;      // the step itself leads, or ties with what leads
  bool telling = false;    // the half is large enough: something is worth its parameters, or the step's refit works
  Eigen::VectorXd values;  // of the step's parameters, SI; empty where the half cannot tell them
  Eigen::MatrixXd covariance;
};

struct Confirmation {
  std::vector<HalfResult> halves;  // two
  double compatible_p = 1.0;       // of the two halves' values being one: chi-square of their difference
  int folds = 0;                   // of the cross-validation
  double cv_before = 0.0;          // predicted chi-square per row of left-out configurations, without the step
  double cv_after = 0.0;           // and with it
};

// `without`: the model with all other steps; `with`: the whole one.
Confirmation ConfirmStep(const DiagnosedModel& without, const DiagnosedModel& with, const ChosenStep& step,
                         const std::vector<Candidate>& candidates, const SelectionOptions& options);

}  // namespace sagitta
