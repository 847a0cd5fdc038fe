// Stated priors that the rows contradict.
#pragma once

#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// One of them, SI.
struct PriorConflict {
  int coordinate = -1;
  double prior_sigma = 0.0;             // as stated
  double rows = 0.0, rows_sigma = 0.0;  // what the rows say without it, by their noise
  double sigmas = 0.0;                  // apart
  double dof = 0.0;                     // that the scatter of what is apart is known with
};

// Of a judged estimate, the worst first; of those that chance brings about in one of 1 / significance experiments none
// (Bonferroni). What the robot file states of an effect's size counts; what a diagnosis assumes of it is no statement.
std::vector<PriorConflict> PriorsAgainstRows(const CalibrationProblem& problem, const Estimate& estimate);

}  // namespace sagitta
