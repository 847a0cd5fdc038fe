// A robot whose place is known, as of an estimate that is read back, against readings: can it have made them? Where
// half of the rows of a marker and station are farther off than arms are (SuspiciousMisfit), and farther than what the
// calibration left open allows, base poses and markers are fitted to all rows: what fits then stands elsewhere; what
// does not is another robot, or readings that were read in a wrong way (reading_lint.h).
#pragma once

#include <vector>

#include "estimator/inspection/finding.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct KnownMisfit {
  bool is_far = false;
  double median = 0.0;  // distance, m: of all rows, or of those of the one marker and station that is off alone
  int station = -1, marker = -1;  // of these; -1: all rows
  // Rows that are far off by themselves, where the others are not.
  std::vector<int> far;  // observations
  double first = 0.0;    // distance of the first of them, m
};

// predicted: m, one column per observation. expected: m, of each observation the RMS distance that the prediction
// itself lets expect (none: nothing is open). Observations without a point are left out.
KnownMisfit MisfitOfKnown(const Chain& chain, const Measurements& rows, const Eigen::Matrix3Xd& predicted,
                          const std::vector<double>& expected = {});

// Why it is far, and the cure. `known`: a problem of prediction, at the robot's parameters and places.
Finding ExplainKnown(const CalibrationProblem& known, const KnownMisfit& misfit);

}  // namespace sagitta
