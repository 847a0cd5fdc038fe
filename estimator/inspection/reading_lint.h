// Data and robot read in another way: wrong units, the other DH convention, joints counted the other way round or
// from another zero. Where the aligned nominal robot misses by far, every reading is tried; one that fits far
// better is what was meant.
#pragma once

#include <string>
#include <vector>

#include "estimator/inspection/finding.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct ReadingMisfit {
  std::string reading;  // "as stated", "modified DH", "joint A2 counted the other way", …
  double rms = 0.0;     // distance, aligned, m
};

struct ReadingLint {
  double misfit = 0.0;                  // as stated, m
  bool is_suspicious = false;           // beyond what calibration can be asked to explain
  bool is_explained = false;            // by another reading
  std::vector<ReadingMisfit> readings;  // as stated first, then what was tried, best first
  std::vector<Finding> findings;
};

// RMS distance, m, of an aligned nominal robot that no calibration explains.
double SuspiciousMisfit(const Chain& chain);

ReadingLint LintReadings(const CalibrationProblem& problem);

}  // namespace sagitta
