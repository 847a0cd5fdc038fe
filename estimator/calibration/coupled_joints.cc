#include "estimator/calibration/coupled_joints.h"

#include <algorithm>

#include "estimator/report/calibration_words.h"

namespace sagitta {

std::vector<std::string> WarningsOfCouplings(const CalibrationProblem& problem, bool all) {
  const Robot& robot = problem.robot();
  std::vector<std::string> words;
  for (const Coupling& coupling : robot.chain.couplings) {
    const bool gives_way = std::any_of(robot.compliances.begin(), robot.compliances.end(),
                                       [&](const auto& compliance) { return compliance.joint == coupling.driver; });
    if (!all && !gives_way) continue;
    const auto& joints = robot.chain.joints;
    words.push_back(FollowsTheCommandAlone(joints[coupling.joint].name, joints[coupling.driver].name));
  }
  return words;
}

}  // namespace sagitta
