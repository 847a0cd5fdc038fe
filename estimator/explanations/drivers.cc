#include "estimator/explanations/drivers.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <set>

#include "estimator/least_squares/row_batches.h"
#include "estimator/statistics/ascending.h"
#include "models/constants.h"
#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

std::vector<int> JointSlots(const Chain& chain) {
  std::vector<int> slots;
  for (int j = 0; j < chain.num_joints(); ++j) slots.push_back(chain.JointTransform(j));
  return slots;
}

using WrenchesOfShot = std::function<std::vector<AppliedWrench>(const ShotInput&)>;

std::vector<int> AllShots(const CalibrationProblem& problem) {
  std::vector<int> shots(problem.shot_inputs().size());
  std::iota(shots.begin(), shots.end(), 0);
  return shots;
}

// On each joint's transform, shots x joints, of the shots that are asked for; zero where the equilibrium diverges.
Eigen::MatrixXd TorquesOfWrenches(const CalibrationProblem& problem, const ParameterSet& parameters,
                                  const std::vector<int>& shots, const WrenchesOfShot& wrenches_of) {
  const Chain& chain = problem.robot().chain;
  const std::vector<int> slots = JointSlots(chain);
  const std::vector<double> theta = parameters.ModelValues();
  Eigen::MatrixXd torques = Eigen::MatrixXd::Zero(problem.shot_inputs().size(), chain.num_joints());
  for (const int s : shots) {
    const ShotInput& shot = problem.shot_inputs()[s];
    const Matrix3<double> rotation = parameters.BaseInStation(problem.data().shots[s].station).rotation;
    const Equilibrium equilibrium = problem.model().Equilibrate(shot, theta.data(), rotation);
    if (!equilibrium.converged) continue;
    const std::vector<AppliedWrench> wrenches = wrenches_of(shot);
    const ElasticQuery query{&chain, &slots, nullptr, &shot.conditions.q, &wrenches, &shot.terms};
    torques.row(s) = TorquesOf(query, equilibrium.state, wrenches, rotation).transpose();
  }
  return torques;
}

// The same of the shots' own wrenches, several shots side by side; zero where a shot has none.
Eigen::MatrixXd TorquesOfOwnWrenches(const CalibrationProblem& problem, const ParameterSet& parameters,
                                     const std::vector<int>& shots) {
  std::vector<int> looked_at;  // an observation of each
  for (const int s : shots) {
    const std::vector<int>& own = problem.data().shots[s].observations;
    if (!problem.shot_inputs()[s].wrenches.empty() && !own.empty()) looked_at.push_back(own.front());
  }
  const NoiseRoots metres(looked_at.size(), Matrix3<double>::Identity());
  const RowBatches batches(problem, looked_at, metres, LatentTreatment::kIgnore, RowsAgainst::kOrigin);
  Eigen::MatrixXd torques = Eigen::MatrixXd::Zero(problem.shot_inputs().size(), problem.robot().chain.num_joints());
  const std::vector<int> left = batches.FindWrenchTorques(parameters, &torques);
  const Eigen::MatrixXd by_model =
      TorquesOfWrenches(problem, parameters, left, [](const ShotInput& shot) { return shot.wrenches; });
  torques(left, Eigen::all) = by_model(left, Eigen::all);
  return torques;
}

// 0 throughout, which drives nothing, where some shots do not state it.
template <typename IsStated, typename Value>
Eigen::VectorXd IfAllState(const CalibrationProblem& problem, const IsStated& is_stated, const Value& value) {
  const std::vector<ShotInput>& shots = problem.shot_inputs();
  const bool all = std::all_of(shots.begin(), shots.end(), [&](const ShotInput& s) { return is_stated(s.conditions); });
  if (!all) return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(shots.size()));
  return OfShots(problem, value);
}

// The joint that a setting names, or else the target.
std::string DrivingJoint(const EffectDefinition& definition, const EffectSpec& spec) {
  for (const SettingDefinition& setting : definition.settings) {
    if (setting.kind == SettingDefinition::Kind::kJoint) return spec.TextSetting(setting.name, spec.target);
  }
  return spec.target;
}

}  // namespace

std::vector<int> FittedShots(const CalibrationProblem& problem) {
  std::set<int> shots;
  for (const int i : problem.CalibrationObservations()) shots.insert(problem.data().observations[i].shot);
  return {shots.begin(), shots.end()};
}

Eigen::VectorXd JointValues(const CalibrationProblem& problem, int joint) {
  return OfShots(problem, [joint](const ShotConditions& shot) { return shot.q[joint]; });
}

bool IsRevolute(const CalibrationProblem& problem, int joint) {
  return problem.robot().chain.joints[joint].type == JointType::kRevolute;
}

Driver AngleOf(const CalibrationProblem& problem, int joint) {
  const bool turns = IsRevolute(problem, joint);
  const double scale = turns ? 1.0 / kDegree : 1e3;
  return {problem.robot().chain.joints[joint].name, turns ? "deg" : "mm",
          turns ? DriverKind::kAngle : DriverKind::kTravel, scale * JointValues(problem, joint)};
}

Driver ApproachOf(const CalibrationProblem& problem, int joint) {
  const auto is_stated = [joint](const ShotConditions& shot) { return shot.StatesApproachOf(joint); };
  return {
      "approach of " + problem.robot().chain.joints[joint].name, "", DriverKind::kOther,
      IfAllState(problem, is_stated, [joint](const ShotConditions& shot) -> double { return shot.approach[joint]; })};
}

Driver TimeOf(const CalibrationProblem& problem) {
  const auto is_stated = [](const ShotConditions& shot) { return shot.has_time; };
  return {"time", "s", DriverKind::kTime,
          IfAllState(problem, is_stated, [](const ShotConditions& shot) { return shot.time; })};
}

Driver TemperatureOf(const CalibrationProblem& problem) {
  const auto is_stated = [](const ShotConditions& shot) { return shot.has_temperature; };
  return {"temperature above its mean", "K", DriverKind::kTemperature,
          IfAllState(problem, is_stated, [](const ShotConditions& shot) { return shot.temperature; })};
}

Driver ConfigurationNumberOf(const CalibrationProblem& problem) {
  Driver driver{"configuration", "", DriverKind::kOther, Eigen::VectorXd(problem.data().shots.size())};
  for (size_t s = 0; s < problem.data().shots.size(); ++s) {
    driver.of_shot[s] = 1.0 + problem.data().shots[s].configuration;
  }
  return driver;
}

Driver OrderOf(const CalibrationProblem& problem) {
  const bool is_timed = std::all_of(problem.shot_inputs().begin(), problem.shot_inputs().end(),
                                    [](const ShotInput& shot) { return shot.conditions.has_time; });
  return is_timed ? TimeOf(problem) : ConfigurationNumberOf(problem);
}

Eigen::MatrixXd JointTorques(const CalibrationProblem& problem, const ParameterSet& parameters,
                             const std::vector<int>* of_shots) {
  const std::vector<int> slots = JointSlots(problem.robot().chain);
  const std::vector<int> shots = of_shots == nullptr ? AllShots(problem) : EachOnce(*of_shots);
  Eigen::MatrixXd torques = TorquesOfOwnWrenches(problem, parameters, shots);
  for (const int s : shots) {
    for (size_t j = 0; j < slots.size(); ++j) {
      const auto stated = StatedTorqueOn(problem.shot_inputs()[s].terms, slots[j]);
      if (stated) torques(s, static_cast<long>(j)) = *stated;
    }
  }
  for (long s = 0; s < torques.rows() && !shots.empty(); ++s) {
    const bool is_known = std::binary_search(shots.begin(), shots.end(), static_cast<int>(s));
    if (!is_known) torques.row(s) = torques.row(shots[0]).eval();
  }
  return torques;
}

Eigen::MatrixXd TorquesPerWeight(const CalibrationProblem& problem, const ParameterSet& parameters) {
  const int flange = problem.robot().chain.FlangeFrame();
  return TorquesOfWrenches(problem, parameters, AllShots(problem), [flange](const ShotInput& shot) {
    AppliedWrench weight;
    weight.frame = flange;
    weight.force = shot.conditions.gravity.normalized();
    weight.expressed_in = shot.conditions.gravity_frame;
    return std::vector<AppliedWrench>{weight};
  });
}

Vector3<double> DownInBase(const CalibrationProblem& problem, const ParameterSet& parameters) {
  Vector3<double> sum = Vector3<double>::Zero();
  for (size_t s = 0; s < problem.shot_inputs().size(); ++s) {
    const ShotConditions& shot = problem.shot_inputs()[s].conditions;
    Vector3<double> down = shot.gravity.normalized();
    if (shot.gravity_frame == WrenchFrame::kMeasurement) {
      down = parameters.BaseInStation(problem.data().shots[s].station).rotation.transpose() * down;
    }
    sum += down;
  }
  return sum.normalized();
}

Driver TorqueOf(const CalibrationProblem& problem, int joint, const Eigen::MatrixXd& joint_torques) {
  return {"torque on " + problem.robot().chain.joints[joint].name, IsRevolute(problem, joint) ? "N m" : "N",
          DriverKind::kTorque, joint_torques.col(joint)};
}

Driver DriverOf(const CalibrationProblem& problem, const EffectSpec& spec) {
  const EffectDefinition* definition = FindEffect(problem.robot(), spec.effect);  // none of the compensator
  const EffectDriver by = definition == nullptr ? EffectDriver::kJoint : definition->DrivenBy(spec);
  if (by == EffectDriver::kTemperature) return TemperatureOf(problem);
  if (by == EffectDriver::kTime) return TimeOf(problem);
  const std::string name = definition == nullptr ? spec.target : DrivingJoint(*definition, spec);
  const int joint = problem.robot().chain.FindJoint(name);
  return joint >= 0 ? AngleOf(problem, joint) : ConfigurationNumberOf(problem);
}

}  // namespace sagitta
