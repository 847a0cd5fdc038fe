#include "estimator/planning/written_order.h"

#include <algorithm>
#include <numeric>

#include "models/effects/catalogue.h"

namespace sagitta {

std::vector<std::string> EffectsOfTheOrder(const CalibrationProblem& problem) {
  std::vector<std::string> paths;
  for (const EffectSpec& spec : problem.robot().effects) {
    if (CarriesOn(*FindEffect(problem.robot(), spec.effect), spec)) paths.push_back(spec.Path());
  }
  return paths;
}

WrittenPlan JudgeAsWritten(const Robot& robot, const Measurements& data, const Experiment& experiment,
                           const PlanRequest& request, const PlanScene& searched, Measurements rows, double amplitude) {
  int campaign = 0;
  for (const Shot& shot : data.shots) campaign = std::max(campaign, shot.campaign + 1);
  for (Shot& shot : rows.shots) {
    if (!request.augment) shot.campaign = campaign;  // what stands in the experiment is not measured before
    // As plan.csv has it: rows without a time are measured one after the other.
    shot.has_time = shot.has_time && searched.goes_with_time;
  }
  PlanRequest written = request;
  written.candidates = &rows;
  written.poses = static_cast<int>(rows.configurations.size());
  written.accuracy = 0.0;
  written.move = false;
  written.random_tests = searched.tests_are_drawn;
  WrittenPlan judged;
  judged.scene = MakePlanScene(robot, data, experiment, written);
  judged.numbers = MakePlanNumbers(judged.scene, request.field, amplitude);
  judged.criterion = CriterionFor(*judged.scene.problem, judged.numbers, request);
  std::vector<int> all(static_cast<size_t>(judged.numbers.set.size()));
  std::iota(all.begin(), all.end(), 0);
  judged.covariance = CovarianceOf(judged.numbers.set, judged.numbers.known, all);
  return judged;
}

}  // namespace sagitta
