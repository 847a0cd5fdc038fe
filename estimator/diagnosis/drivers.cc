#include "estimator/diagnosis/drivers.h"

#include <functional>

namespace sagitta {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;

Driver PerShot(const CalibrationProblem& problem, const std::string& name, const std::string& unit,
               const std::function<double(const ShotConditions&)>& value) {
  Driver driver{name, unit, Eigen::VectorXd(static_cast<long>(problem.shot_inputs.size()))};
  for (size_t s = 0; s < problem.shot_inputs.size(); ++s) {
    driver.of_shot[static_cast<long>(s)] = value(problem.shot_inputs[s].conditions);
  }
  return driver;
}

}  // namespace

bool Turns(const CalibrationProblem& problem, int joint) {
  return problem.robot.chain.joints[joint].type == JointType::kRevolute;
}

Driver AngleOf(const CalibrationProblem& problem, int joint) {
  const double scale = Turns(problem, joint) ? kDegreesPerRadian : 1e3;
  return PerShot(problem, problem.robot.chain.joints[joint].name, Turns(problem, joint) ? "deg" : "mm",
                 [&](const ShotConditions& shot) { return scale * shot.q[joint]; });
}

Driver ApproachOf(const CalibrationProblem& problem, int joint) {
  return PerShot(problem, "approach of " + problem.robot.chain.joints[joint].name, "",
                 [joint](const ShotConditions& shot) -> double {
                   return shot.StatesApproachOf(joint) ? shot.approach[joint] : 0.0;
                 });
}

Driver TimeOf(const CalibrationProblem& problem) {
  return PerShot(problem, "time", "s", [](const ShotConditions& shot) { return shot.has_time ? shot.time : 0.0; });
}

Driver TemperatureOf(const CalibrationProblem& problem) {
  return PerShot(problem, "temperature above its mean", "K",
                 [](const ShotConditions& shot) { return shot.has_temperature ? shot.temperature : 0.0; });
}

Driver ConfigurationNumberOf(const CalibrationProblem& problem) {
  Driver driver{"configuration", "", Eigen::VectorXd(static_cast<long>(problem.data.shots.size()))};
  for (size_t s = 0; s < problem.data.shots.size(); ++s) {
    driver.of_shot[static_cast<long>(s)] = 1.0 + problem.data.shots[s].configuration;
  }
  return driver;
}

Eigen::MatrixXd JointTorques(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const Chain& chain = problem.robot.chain;
  std::vector<int> slots;
  for (size_t j = 0; j < chain.joints.size(); ++j) slots.push_back(chain.JointTransform(static_cast<int>(j)));
  const std::vector<double> theta = parameters.ModelValues();
  Eigen::MatrixXd torques = Eigen::MatrixXd::Zero(static_cast<long>(problem.shot_inputs.size()), slots.size());
  for (size_t s = 0; s < problem.shot_inputs.size(); ++s) {
    const ShotInput& shot = problem.shot_inputs[s];
    const Matrix3<double> rotation = parameters.BaseInStation(problem.data.shots[s].station).rotation;
    const Equilibrium equilibrium = problem.model.Equilibrate(shot, theta.data(), rotation);
    if (!equilibrium.converged) continue;
    const ElasticQuery query{&chain, &slots, nullptr, &shot.conditions.q, &shot.wrenches, &shot.terms};
    torques.row(static_cast<long>(s)) = TorquesOf(query, equilibrium.state, shot.wrenches, rotation).transpose();
    for (size_t j = 0; j < slots.size(); ++j) {
      if (const auto stated = StatedTorqueOn(shot.terms, slots[j])) torques(static_cast<long>(s), j) = *stated;
    }
  }
  return torques;
}

Driver TorqueOf(const CalibrationProblem& problem, int joint, const Eigen::MatrixXd& joint_torques) {
  return {"torque on " + problem.robot.chain.joints[joint].name, Turns(problem, joint) ? "N m" : "N",
          joint_torques.col(joint)};
}

}  // namespace sagitta
