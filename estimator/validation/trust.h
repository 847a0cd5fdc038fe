// May the estimate be believed, how far, and with what interval? One verdict of everything that was checked: errors on
// points that the estimate has not seen against what it predicted for them, parts of the data against each other,
// suspect rows, what was not measured.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "estimator/validation/cross_validation.h"
#include "estimator/validation/suspects.h"

namespace sagitta {

struct Verdict {
  std::string words;
  bool trusted = false;
  std::vector<std::string> reasons;  // why not
};

struct Trust {
  CrossValidation cross_validation;  // on calibration rows
  UnseenPoints holdout;              // on validation rows; no points: nothing is held out
  UnseenPoints nominal;              // of the aligned nominal robot, on the points that are quoted
  PoseRepeatability repeatability;   // RP of ISO 9283, of all points
  std::vector<Suspect> suspects;
  double model_error = 1.0;               // factor by which model error widens the intervals; 1: none was found
  std::string model_error_words;          // empty: none
  std::vector<Interval> ci95_noise_only;  // of each line of the estimate's table
  Verdict verdict;

  // What the verdict quotes: the hold-out where there is one, else the cross-validation.
  const UnseenPoints& Quoted() const { return holdout.points > 0 ? holdout : cross_validation.unseen; }
};

// Of a judged estimate with its intervals and agreement. Widens the intervals of its table by the model error.
Trust JudgeTrust(const CalibrationProblem& problem, std::uint64_t seed, Estimate* estimate);

}  // namespace sagitta
