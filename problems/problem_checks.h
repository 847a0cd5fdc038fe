// What only robot, data and experiment together show to be wrong. Each check throws InputError.
#pragma once

#include <optional>
#include <string>

#include "problems/calibration_problem.h"

namespace sagitta {

// Of a key of the experiment file, or of the nearest map around it that the file has; 0: none.
int LineOf(const Experiment& experiment, std::string key);

// At `key` of the experiment file.
[[noreturn]] void FailProblem(const CalibrationProblem& problem, const std::string& key, const std::string& what,
                              const std::string& hint = "");
[[noreturn]] void FailProblem(const Experiment& experiment, const std::string& key, const std::string& what,
                              const std::string& hint = "");

// Markers and stations of the experiment that no row has.
void CheckNames(const CalibrationProblem& problem);

// Joints that effects name, before a model is made of them.
void CheckJointsOfEffects(const Robot& robot, const Experiment& experiment);

// Targets that only the data know.
void CheckEffects(const CalibrationProblem& problem);

// A column that an effect of the robot needs and a row has not.
struct NeededColumn {
  std::string effect;  // its path
  std::string column;
  int shot = -1;
};
std::optional<NeededColumn> ColumnOfAnEffect(const CalibrationProblem& problem);
// what_else: instead of adding the column.
void CheckEffectColumns(const CalibrationProblem& problem, const std::string& what_else);

// Weights at a station that says it is not levelled, with gravity stated in the measurement frame.
void CheckLevelled(const CalibrationProblem& problem);
// The first station of that kind; "" without one.
std::string UnlevelledStationWithWeights(const CalibrationProblem& problem);

// A spring can neither have no length nor be pressed through zero.
void CheckCompensator(const CalibrationProblem& problem);

// What is fitted was read: rows without x, y, z may be predicted and planned with, no more.
void CheckRowsAreRead(const CalibrationProblem& problem);

// What no estimate can come from.
void CheckEnoughData(const CalibrationProblem& problem);

}  // namespace sagitta
