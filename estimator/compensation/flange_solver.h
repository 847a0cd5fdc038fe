// Joint values at which a robot's flange stands on a target.
//
// Damped Newton on the task error e = [p* - p; L_r log(R* R')], e = J dq + ..., steps of least norm by SVD (Wampler
// 1986; Nakamura and Hanafusa 1986; Siciliano et al., Robotics: Modelling, Planning and Control, sec. 3.5 and 3.7). J
// is the derivative of the loaded arm by its joint values (FlangeState::by_joints). With more joints than the task
// needs the rest is drawn to the start, so that q ends at the least distance from it; with fewer, positions come first
// (L_r small) and orientation is met as far as it can be. Joints that would leave their limits stop there, and the
// others go on.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "models/forward_model.h"

namespace sagitta {

// Where the flange stands, in the base frame as it stands on the ground, and how that changes.
struct FlangeState {
  Pose<double> flange_in_base;
  // d (p, rotation as left perturbation) / d q of the loaded arm, SI, its effects and compliances held as they are at
  // q. Left out is how these change with the commanded q: the values of a compliance table, joint_harmonic,
  // axis_wobble, encoder_gain, joint_coupling, a compensator without preload. On an arm of 1.5 m: 1 to 2 mm per rad of
  // 500 urad or 1000 ppm, 3 mm per rad of a table from 1 to 5 urad/Nm under 60 kg, 40 mm per rad of a spring of 150
  // N/mm without preload. Newton's steps are shorter or longer by that share; where they end does not depend on it.
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_joints;
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_parameters;  // of the parameters asked for
};

// A robot in one shot: everything but q is held.
class LoadedArm {
 public:
  // theta: one value per model parameter, SI; base_rotation: R of base_in_station, for what is given in the measurement
  // frame. The model outlives the arm. Throws std::invalid_argument for another number of values.
  LoadedArm(const ForwardModel& model, std::vector<double> theta);
  LoadedArm(ForwardModel&& model, std::vector<double> theta) = delete;

  // False: no equilibrium, a load folds the arm.
  bool At(const Eigen::VectorXd& q, ShotInput shot, const Matrix3<double>& base_rotation,
          const std::vector<int>& parameters, FlangeState* state) const;
  const Chain& chain() const { return model_.chain(); }

 private:
  const ForwardModel& model_;
  std::vector<double> theta_;
};

// How a target came out.
enum class TargetStatus { kOk, kSingular, kLimit, kUnreachable, kEquilibriumDiverged, kNotConverged };
// "ok", "singular", ...
const char* StatusName(TargetStatus status);

// On target within these: 1e-6 mm, and 1e-6 mrad, a nanometre at one metre.
constexpr double kOnTarget = 1e-9;  // m and rad

// Joint values for a flange pose.
struct FlangeSolution {
  TargetStatus status = TargetStatus::kNotConverged;
  Eigen::VectorXd q;
  FlangeState state;            // at q
  double left_position = 0.0;   // m
  double left_rotation = 0.0;   // rad
  double least_singular = 0.0;  // of J with lengths in units of the reach, see LeastSingularValue
  std::vector<int> at_limit;    // joints
  int iterations = 0;
};

// Sum of the lengths along the chain, m: the unit in which positions and angles are weighed against each other.
double CharacteristicLength(const Chain& chain);

// Smallest of the singular values of the flange's Jacobian that the number of joints allows (position alone below six
// joints), lengths in units of the reach. With the wrist 1 degree out of line a KR 270's is 0.0025 to 0.007, and it
// grows with that angle; below kNearSingular a target counts as singular.
double LeastSingularValue(const Chain& chain, const FlangeState& state);
constexpr double kNearSingular = 0.0035;

// position error (m) and rotation error (rad) of a pose against a target, both in the base frame.
Eigen::Matrix<double, 6, 1> PoseDifference(const Pose<double>& target, const Pose<double>& at);

using FlangeFunction = std::function<bool(const Eigen::VectorXd& q, FlangeState* state)>;

// Joint values number k = 0, 1, .. to start from: the middle of the limits, then points that fill the joint space
// evenly. A joint without limits ranges over a turn or the characteristic length to either side of zero, half of it
// each; within_a_turn: one with limits over no more than that turn.
Eigen::VectorXd SpreadStart(const Chain& chain, int k, bool within_a_turn);

// From `start`, which also is what a redundant arm stays near. within_limits: joints stop at their limits.
FlangeSolution SolveFlange(const Chain& chain, const FlangeFunction& arm, const Pose<double>& target,
                           const Eigen::VectorXd& start, bool within_limits);

}  // namespace sagitta
