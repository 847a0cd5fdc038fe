// Some rows where all are too many to be held at once.
#pragma once

#include <vector>

#include "estimator/least_squares/row_sums.h"

namespace sagitta {

// Numbers, rows by columns, that show what they show as well as all do: those of a step of fifty columns, below. Of few
// columns they are thousands of rows.
constexpr double kEnoughNumbers = 2.5e5;

// Of the listed observations those of as many configurations, scattered over all, as `columns` and three rows each make
// `most` numbers of: all where these are no more.
std::vector<int> SampleConfigurations(const Measurements& data, const std::vector<int>& observations, size_t columns,
                                      double most);
// For a step of `columns`: all where they can be held, else so many that the step moves points by a tenth of the noise
// from where all would put them.
std::vector<int> SampleForStep(const Measurements& data, const std::vector<int>& observations, size_t columns);

}  // namespace sagitta
