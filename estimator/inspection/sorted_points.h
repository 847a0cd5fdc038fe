// Points that were sorted by one of their coordinates while the joint values were not: every row has the point of some
// other. Which, the coordinate says itself: where base and marker are about known, the k-th least of the predicted
// values belongs to the k-th row. From that order base poses and markers are fitted, and the order found anew, in turns
// from many directions of the coordinate; in the end the nearest points of neighbours in that order are matched, for
// predictions that lie closer to each other than the robot's errors change places (iterative closest points: Besl,
// McKay, A method for registration of 3-D shapes, IEEE Transactions on Pattern Analysis and Machine Intelligence 14
// (1992) 239).
#pragma once

#include <optional>

#include "estimator/inspection/finding.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Nothing where no coordinate rises or falls from shot to shot, or where the robot fits in no such order.
std::optional<Finding> FindSortedPoints(const CalibrationProblem& problem);

}  // namespace sagitta
