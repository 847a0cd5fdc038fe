// What a plan is made on: measured rows, candidates and test poses in one problem, and where everything stands.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "estimator/planning/feasible.h"
#include "estimator/planning/plan.h"
#include "problems/calibration_problem.h"

namespace sagitta {

struct PlanScene {
  // Configurations of the problem's data.
  std::vector<int> candidates, tests, measured;
  bool tests_are_drawn = false;
  // Configurations that may be moved anywhere, one per way to measure; of each candidate which of them is its way, -1
  // where it is listed and stays where it is.
  std::vector<int> movable;
  std::vector<int> way_of;
  std::vector<JointRange> ranges;  // that poses are drawn in; empty: candidates are listed

  std::unique_ptr<CalibrationProblem> placed;  // what `feasible` looks at
  std::unique_ptr<FeasiblePoses> feasible;
  std::unique_ptr<CalibrationProblem> problem;

  // Effects of the robot go with them, so that each pose has its own: those of the rows that are measured like it.
  bool goes_with_time = false, goes_with_temperature = false;

  std::vector<EffectSpec> field;  // of the model error, in `problem` (model_field.h)

  std::map<std::string, int> infeasible;  // how many of those tried were not feasible, by reason
  std::vector<std::string> words;
};

// Throws InputError where there is nothing to choose from, nothing to be accurate at, or nothing says where markers
// are.
PlanScene MakePlanScene(const Robot& robot, const Measurements& data, const Experiment& experiment,
                        const PlanRequest& request);

}  // namespace sagitta
