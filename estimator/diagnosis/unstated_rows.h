// Shots that do not state what nearly all others do: a time, a temperature, from where a joint came.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// A column that drives effects, by its name in measurement files.
struct DrivingColumn {
  std::string name;
  std::function<bool(const ShotConditions&)> is_stated;
};
std::vector<DrivingColumn> DrivingColumns(int joints);

// The problem without the rows of a few shots that leave such a column empty, so that what it drives can be looked for;
// nothing where no shot does, or more than a quarter of all or half of those of a station, a load, a marker or the
// hold-out do, which are worth more than the column. `cautions`: says what is left out.
std::optional<CalibrationProblem> WithoutUnstatedRows(const CalibrationProblem& problem,
                                                      std::vector<std::string>* cautions);

}  // namespace sagitta
