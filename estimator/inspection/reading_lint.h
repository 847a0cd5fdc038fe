// Data and robot read in another way: wrong units, the other DH convention, joints counted the other way round, from
// another zero or in another order, a mirrored frame (readings.h). Where the aligned nominal robot misses by far and no
// errors of a size that robots have explain it (explained_errors.h), every reading is tried on some hundred
// configurations (sampled_problem.h); one that fits far better is what was meant.
#pragma once

#include <string>
#include <vector>

#include "estimator/alignment/aligned_misfit.h"
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
  std::vector<int> wrong_rows;  // observations that were read in another way than the others
};

// RMS distance, m, above which an aligned nominal robot's misfit has to be explained.
double SuspiciousMisfit(const Chain& chain);
double SuspiciousMisfit(const CalibrationProblem& problem);

// Each of these begins with the aligned robot; without, it is aligned here.
ReadingLint LintReadings(const CalibrationProblem& problem, const AlignedSample& aligned);
ReadingLint LintReadings(const CalibrationProblem& problem);

// The same without the rows that are far off, where all rows together cannot be explained: a misfit of a few rows is
// theirs alone (row_lint.h names them).
ReadingLint LintReadingsOfGoodRows(const CalibrationProblem& problem, const AlignedSample& aligned);
ReadingLint LintReadingsOfGoodRows(const CalibrationProblem& problem);

// What every estimating command asks first: can the nominal robot have made these readings?
struct Plausibility {
  bool plausible = true;
  Finding finding;  // why not, and the cure
};
Plausibility CheckPlausible(const CalibrationProblem& problem, const AlignedSample& aligned);

}  // namespace sagitta
