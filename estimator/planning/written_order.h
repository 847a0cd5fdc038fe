// What a plan brings in the order in which its rows are written. An effect that remembers the shots before (hysteresis,
// heat) makes of a pose what was done before makes of it: the search counts each candidate after its neighbours in the
// list, and what is measured before the chosen ones is known only when they are.
#pragma once

#include <string>
#include <vector>

#include "estimator/planning/numbers.h"

namespace sagitta {

// Paths (EffectSpec::Path) of the effects that go with the order of the rows: those that remember.
std::vector<std::string> EffectsOfTheOrder(const CalibrationProblem& problem);

// All poses of a plan, judged by themselves.
struct WrittenPlan {
  PlanScene scene;
  PlanNumbers numbers;
  Criterion criterion;
  Eigen::MatrixXd covariance;  // scaled
};

// rows: the plan's, in their order, after the experiment's where these are measured already. searched: the scene that
// they were chosen in. amplitude: of the model error's field, rad, as the search has it.
WrittenPlan JudgeAsWritten(const Robot& robot, const Measurements& data, const Experiment& experiment,
                           const PlanRequest& request, const PlanScene& searched, Measurements rows, double amplitude);

}  // namespace sagitta
