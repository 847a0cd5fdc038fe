// May the estimate be believed, how far, and with what interval? One verdict of everything that was checked: errors on
// points that the estimate has not seen against what it predicted for them, parts of the data against each other,
// suspect rows, what was not measured.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimator/agreement/between_parts.h"
#include "estimator/inspection/load_direction.h"
#include "estimator/inspection/torque_lint.h"
#include "estimator/validation/cross_validation.h"
#include "estimator/validation/noise_share.h"
#include "estimator/validation/suspects.h"

namespace sagitta {

struct Verdict {
  std::string words;
  bool trusted = false;
  std::vector<std::string> reasons;  // why not
};

// Whether the calibrated robot may be used, and on what grounds.
struct Trust {
  CrossValidation cross_validation;  // on calibration rows
  UnseenPoints holdout;              // on validation rows; no points: nothing is held out
  UnseenPoints nominal;              // of the aligned nominal robot, on the points that are quoted, by no fit to them
  Gain gain;                         // on these
  NoiseShare noise;                  // of the errors that are quoted
  PoseRepeatability repeatability;   // RP of ISO 9283, of all points
  std::vector<Suspect> suspects;
  std::optional<LoadDirection> across;  // where weights do not pull as stated
  TorqueComparison torques;             // where rows state them
  // Model error: what it is between parts of the data, at least the excess where points that were not fitted are off by
  // more than predicted.
  BetweenParts between;                   // not known: the parts agree
  double excess = 1.0;                    // 1: none
  double model_error = 1.0;               // factor by which it widens the intervals, their median; 1: none was found
  std::string model_error_words;          // empty: none
  double model_error_sigma = 1.0;         // the same of standard deviations
  std::vector<double> sigma;              // SI, with model error, of each line of the estimate's table
  std::vector<Interval> ci95_noise_only;  // the same without
  std::vector<std::string> limits;        // sentences on what the verdict does not cover
  Verdict verdict;

  // What the verdict quotes: the hold-out where there is one, else the cross-validation.
  const UnseenPoints& Quoted() const { return holdout.points > 0 ? holdout : cross_validation.unseen; }
};

// What squares of the errors of the points held out are expected by a judged estimate, at the noise that it goes by.
// Nothing where no point is held out or the arm has no equilibrium.
std::optional<PredictedSquares> PredictedOfHoldout(const CalibrationProblem& problem, const Estimate& estimate);

// Of a judged estimate with its intervals; between: what CheckAgreement found. Widens the intervals of its table by the
// model error.
Trust JudgeTrust(const CalibrationProblem& problem, const FittedStream& fitted, const FoldPlan& folds,
                 Estimate* estimate, const BetweenParts& between);

// The same by the points held out alone, of an estimate that is known to follow a cause in part, as what is learnt of
// one without a name: all that these points are off by beyond scatter is model error, not only what is beyond chance.
// No verdict. Widens the intervals in the table.
Trust JudgeByHoldout(const CalibrationProblem& problem, Estimate* estimate);

}  // namespace sagitta
