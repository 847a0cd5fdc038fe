// Ways to divide the configurations of a data set in two.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "problems/calibration_problem.h"

namespace sagitta {

// Configurations of a part: with one marker 15 equations, to six numbers of a base, three of a marker and six degrees
// of freedom (kFewestFree).
constexpr size_t kFewestOfPart = 5;

struct Split {
  SplitBy by = SplitBy::kRandom;
  std::string key;         // as in PartComparison
  std::vector<int> first;  // positions in the list of calibration observations
  std::vector<int> second;
};

// clusters: the configuration of each calibration observation. Rows of one come apart by station, marker and load
// alone.
std::vector<Split> MakeSplits(const CalibrationProblem& problem, const Estimate& estimate,
                              const std::vector<int>& clusters, unsigned long long seed, int random_halves);

}  // namespace sagitta
