// Positioning in the terms of ISO 9283:1998, "Manipulating industrial robots - Performance criteria and related test
// methods". A pose is a configuration. A commanded position is what the model says of one configuration, marker,
// station, load and approach; its attained positions are those of the n arrivals (visits) there, repeated readings of
// one arrival averaged. A pose that is seen with three markers has three of them.
//
//   7.2.1  AP_p = | barycentre of the attained positions - commanded position |
//   7.2.2  RP_l = mean(l) + 3 S_l,   l_j = | position j - barycentre |,   S_l^2 = sum_j (l_j - mean(l))^2 / (n - 1)
//
// As restated by Slamani, Nubiola and Bonev (Industrial Robot 39(1), 2012) and in J. Leland's ISO9283TestAnalyzer (MIT
// Media Lab, 2016: mean of l plus three corrected sample standard deviations). The standard asks for n = 30 arrivals;
// how many there were is stated next to the figures, and of fewer than kFewestArrivals there are none.
#pragma once

#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// Two arrivals are equally far from their barycentre: S_l is 0 whatever the robot does, and RP a fraction of what it
// is.
constexpr int kFewestArrivals = 3;

struct PoseAccuracy {
  int poses = 0;
  int positions = 0;                 // commanded: each marker, station, load and approach of a pose by itself
  double mean = 0.0, largest = 0.0;  // AP_p over the positions, m
  double scatter = 0.0;              // of repeated readings about their arrival's mean, RMS distance, m; 0: none
};

// RP of ISO 9283, as far as repeated arrivals show it.
struct PoseRepeatability {
  int poses = 0;                     // with kFewestArrivals or more
  int positions = 0;                 // commanded ones among them
  int fewest = 0;                    // arrivals at one of them
  int most = 0;                      // arrivals at one position, be they too few
  double mean = 0.0, largest = 0.0;  // RP_l over the positions, m
};

// errors: measured - commanded (3 x N, m), one column per observation, of points.
PoseAccuracy MeasurePoseAccuracy(const CalibrationProblem& problem, const std::vector<int>& observations,
                                 const Eigen::Matrix3Xd& errors);

// Of all points that are no outliers; the instrument's noise is in it.
PoseRepeatability MeasurePoseRepeatability(const CalibrationProblem& problem);

}  // namespace sagitta
