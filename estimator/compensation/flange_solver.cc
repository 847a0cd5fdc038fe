#include "estimator/compensation/flange_solver.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "models/constants.h"

namespace sagitta {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kMostIterations = 200;    // 16 of the longest steps are half a turn; the others are damped
constexpr double kStandsStill = 1e-13;  // of a step in rad or m: rounding of joint values of a few rad
constexpr double kQuadratic = 1e-7;     // rad or m: after a step this long Newton's next one is rounding
constexpr double kLongestStep = 0.2;    // rad or m: a Newton step beyond that leaves the branch it is on
// Of an angle below six joints. What an orientation that is 0.1 rad out of reach costs the position is its square
// times that, 1e-11 of the reach.
constexpr double kAngleWeight = 1e-5;
// Steps towards a pose that cannot be reached gain ever less; far from the target (in units of the reach, or rad) they
// end where they gain a millionth. Steps to one that can are quadratic and never gain so little there.
constexpr double kNoFlangeGain = 1e-6;
constexpr double kFarOff = 1e-6;
constexpr double kGentle = 1e-2;       // a step damped beyond that gains little wherever it leads
constexpr double kLimitSlack = 1e-12;  // rad or m
// Singular values below this share of the largest carry no information in double precision.
constexpr double kRankShare = 1e-12;

// One Newton problem: which joints move, and how errors are weighed.
class Newton {
 public:
  Newton(const Chain& chain, const FlangeFunction& arm, const Pose<double>& target, const Eigen::VectorXd& reference)
      : arm_(arm), target_(target), reference_(reference), moves_(chain.num_joints(), true) {
    const double reach = CharacteristicLength(chain);
    weight_.head<3>().setConstant(1.0 / reach);
    weight_.tail<3>().setConstant(chain.num_driven() < 6 ? kAngleWeight : 1.0);
    for (int j = 0; j < chain.num_joints(); ++j) moves_[j] = !chain.joints[j].IsHeld();
  }

  void Hold(int joint) { moves_[joint] = false; }

  // False: no equilibrium at the start.
  bool Run(FlangeSolution* solution) {
    Eigen::VectorXd q = solution->q;
    if (!arm_(q, &solution->state)) return false;
    double error = Error(solution->state).norm();
    double damping = 0.0;
    bool settled = false;
    for (int i = 0; i < kMostIterations && !settled; ++i, ++solution->iterations) {
      const Eigen::VectorXd step = Step(solution->state, q, damping);
      if (step.lpNorm<Eigen::Infinity>() < kStandsStill) settled = true;
      FlangeState next;
      const bool stands = arm_(q + step, &next);
      const double next_error = stands ? Error(next).norm() : std::numeric_limits<double>::infinity();
      // Where the error is at the rounding of the kinematics, the rest of the step is along the null space.
      if (next_error <= error || next_error < kRounding) {
        const bool slow = damping < kGentle && error - next_error < kNoFlangeGain * error && next_error > kFarOff;
        q += step, error = next_error, solution->state = next;
        // Of squared singular values: from those of 1e-3, one near a singularity, up to steps of a thousandth.
        damping = damping < 1e-8 ? 0.0 : damping / 10.0;
        settled |= slow || (error < kRounding && step.lpNorm<Eigen::Infinity>() < kQuadratic);
      } else {
        if (settled || damping > 1e3) {
          settled = true;
          break;
        }
        damping = std::max(1e-6, 10.0 * damping);
      }
    }
    solution->q = q;
    if (!settled) solution->status = TargetStatus::kNotConverged;
    return settled || solution->iterations > 0;
  }

  Vector6 Error(const FlangeState& state) const {
    return weight_.cwiseProduct(PoseDifference(target_, state.flange_in_base));
  }

 private:
  static constexpr double kRounding = 1e-14;  // of the reach and of rad: some hundred products of 1e-16

  Eigen::VectorXd Step(const FlangeState& state, const Eigen::VectorXd& q, double damping) const {
    Eigen::MatrixXd jacobian = weight_.asDiagonal() * state.by_joints;
    for (size_t j = 0; j < moves_.size(); ++j) {
      if (!moves_[j]) jacobian.col(j).setZero();
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Eigen::VectorXd& s = svd.singularValues();
    const Eigen::VectorXd along = svd.matrixU().transpose() * Error(state);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(q.size());
    // What the task leaves open goes back towards the start: its part in the null space of J.
    Eigen::VectorXd home = reference_ - q;
    for (size_t j = 0; j < moves_.size(); ++j) {
      if (!moves_[j]) home[j] = 0.0;
    }
    for (int i = 0; i < s.size(); ++i) {
      if (s[i] <= kRankShare * s[0]) continue;
      const auto direction = svd.matrixV().col(i);
      // (J'J + damping)^-1 J'e, direction by direction: s / (s^2 + damping).
      step += s[i] / (s[i] * s[i] + damping) * along[i] * direction;
      home -= direction.dot(home) * direction;
    }
    if (std::count(moves_.begin(), moves_.end(), true) > 6) step += home;
    for (size_t j = 0; j < moves_.size(); ++j) {
      if (!moves_[j]) step[j] = 0.0;  // but for rounding it is
    }
    const double longest = step.lpNorm<Eigen::Infinity>();
    return longest > kLongestStep ? Eigen::VectorXd(kLongestStep / longest * step) : step;
  }

  const FlangeFunction& arm_;
  const Pose<double> target_;
  const Eigen::VectorXd reference_;
  std::vector<bool> moves_;
  Vector6 weight_;
};

// How far joint j is beyond its limits, and the limit.
double BeyondLimit(const Joint& joint, double q, double* limit) {
  if (joint.min && q < *joint.min - kLimitSlack) return *limit = *joint.min, *joint.min - q;
  if (joint.max && q > *joint.max + kLimitSlack) return *limit = *joint.max, q - *joint.max;
  return 0.0;
}

// The joint farthest beyond its limits; -1: none.
int WorstJoint(const Chain& chain, const Eigen::VectorXd& q, double* limit) {
  int worst = -1;
  double most = 0.0;
  for (int j = 0; j < chain.num_joints(); ++j) {
    double at = 0.0;
    const double beyond = BeyondLimit(chain.joints[j], q[j], &at);
    if (beyond <= most) continue;
    worst = j, most = beyond, *limit = at;
  }
  return worst;
}

// Whatever the joints do: farther from the frame before the first one than the lengths and travels behind it add up to.
bool IsBeyondReach(const Chain& chain, const Vector3<double>& target) {
  constexpr double kSlack = 1.01;  // estimated lengths are others by far less
  Pose<double> foot;
  double reach = 0.0;
  bool is_foot = true;
  for (const ElementaryTransform& transform : chain.transforms) {
    is_foot &= !transform.has_joint();
    const Vector3<double> axis = Vector3<double>::Unit(static_cast<int>(transform.axis));
    if (is_foot && transform.is_rotation()) {
      foot.rotation = foot.rotation * Eigen::AngleAxisd(transform.nominal, axis);
    } else if (is_foot) {
      foot.translation += transform.nominal * (foot.rotation * axis);
    } else if (!transform.is_rotation() && !transform.has_joint()) {
      reach += std::abs(transform.nominal);
    } else if (!transform.is_rotation()) {
      const Joint& joint = chain.joints[static_cast<size_t>(transform.joint)];
      const auto moves_it = [&](const auto& coupling) { return coupling.joint == transform.joint; };
      const bool is_coupled = std::any_of(chain.couplings.begin(), chain.couplings.end(), moves_it);
      if (!joint.min || !joint.max || is_coupled) return false;
      reach += std::abs(transform.nominal) + std::max(std::abs(*joint.min), std::abs(*joint.max));
    }
  }
  return (target - foot.translation).norm() > kSlack * reach;
}

TargetStatus JudgeSolution(const Chain& chain, const FlangeSolution& solution) {
  const bool orientation_counts = chain.num_driven() >= 6;
  const bool there =
      solution.left_position <= kOnTarget && (!orientation_counts || solution.left_rotation <= kOnTarget);
  if (!there && !solution.at_limit.empty()) return TargetStatus::kLimit;
  if (!there) return TargetStatus::kUnreachable;
  return solution.least_singular < kNearSingular ? TargetStatus::kSingular : TargetStatus::kOk;
}

}  // namespace

const char* StatusName(TargetStatus status) {
  switch (status) {
    case TargetStatus::kOk:
      return "ok";
    case TargetStatus::kSingular:
      return "singular";
    case TargetStatus::kLimit:
      return "limit";
    case TargetStatus::kUnreachable:
      return "unreachable";
    case TargetStatus::kEquilibriumDiverged:
      return "equilibrium_diverged";
    case TargetStatus::kNotConverged:
      return "not_converged";
  }
  return "";
}

// Four points of the flange, its origin and one metre along each of its axes, give pose and derivative.
LoadedArm::LoadedArm(const ForwardModel& model, std::vector<double> theta) : model_(model), theta_(std::move(theta)) {
  if (static_cast<int>(theta_.size()) == model_.num_parameters()) return;
  throw std::invalid_argument("LoadedArm: " + std::to_string(theta_.size()) + " values, the model has " +
                              std::to_string(model_.num_parameters()) + " parameters");
}

bool LoadedArm::At(const Eigen::VectorXd& q, ShotInput shot, const Matrix3<double>& base_rotation,
                   const std::vector<int>& parameters, FlangeState* state) const {
  shot.conditions.q = q;
  model_.PrepareAgain(&shot);
  shot.terms.station.clear();  // what the instrument sees is no matter of where the flange is
  shot.terms.sights.clear();
  constexpr int kNoMarker = -2;
  const int flange = chain().FlangeFrame();
  std::vector<MarkerInFrame> points = {{flange, Vector3<double>::Zero(), kNoMarker}};
  for (int i = 0; i < 3; ++i) points.push_back({flange, Vector3<double>::Unit(i), kNoMarker});
  const std::vector<double> no_deviation(chain().num_joints(), 0.0);
  std::vector<PointPrediction> seen;
  if (!model_.Predict(shot, theta_.data(), parameters, {base_rotation, Vector3<double>::Zero()}, points, &seen,
                      no_deviation.data())) {
    return false;
  }
  const Matrix3<double> to_base = base_rotation.transpose();
  state->flange_in_base.translation = to_base * seen[0].point;
  state->by_joints.setZero(6, q.size());
  state->by_parameters.setZero(6, parameters.size());
  state->by_joints.topRows<3>() = to_base * seen[0].d_latent;
  state->by_parameters.topRows<3>() = to_base * seen[0].d_theta;
  for (int i = 0; i < 3; ++i) {
    const Vector3<double> axis = (to_base * (seen[i + 1].point - seen[0].point)).normalized();
    state->flange_in_base.rotation.col(i) = axis;
    // omega = 1/2 sum r_i x dr_i over the three axes r_i of a rotation.
    const Matrix3<double> half = 0.5 * Skew(axis) * to_base;
    state->by_joints.bottomRows<3>() += half * (seen[i + 1].d_latent - seen[0].d_latent);
    state->by_parameters.bottomRows<3>() += half * (seen[i + 1].d_theta - seen[0].d_theta);
  }
  // A driver moves the joints that are coupled to it too.
  Eigen::MatrixXd coupled = Eigen::MatrixXd::Identity(q.size(), q.size());
  if (!chain().couplings.empty()) {
    const Eigen::VectorXd zero = chain().CoupledJointValues(Eigen::VectorXd::Zero(q.size()));
    for (int j = 0; j < q.size(); ++j) {
      coupled.col(j) = chain().CoupledJointValues(Eigen::VectorXd::Unit(q.size(), j)) - zero;
    }
    state->by_joints = (state->by_joints * coupled).eval();
  }
  return true;
}

double CharacteristicLength(const Chain& chain) {
  double reach = 0.0;
  for (const ElementaryTransform& transform : chain.transforms) {
    if (!transform.is_rotation() && !transform.has_joint()) reach += std::abs(transform.nominal);
  }
  return reach > 0.0 ? reach : 1.0;
}

double LeastSingularValue(const Chain& chain, const FlangeState& state) {
  const int driven = chain.num_driven();
  if (driven == 0) return 0.0;
  Eigen::MatrixXd jacobian(driven < 6 ? 3 : 6, driven);
  for (int j = 0, own = 0; j < chain.num_joints(); ++j) {
    if (chain.joints[j].IsHeld()) continue;
    jacobian.col(own) = state.by_joints.col(j).head(jacobian.rows());
    if (chain.joints[j].type == JointType::kPrismatic) jacobian.col(own) *= CharacteristicLength(chain);
    ++own;
  }
  jacobian.topRows<3>() /= CharacteristicLength(chain);
  return Eigen::JacobiSVD<Eigen::MatrixXd>(jacobian).singularValues().tail<1>()[0];
}

Eigen::Matrix<double, 6, 1> PoseDifference(const Pose<double>& target, const Pose<double>& at) {
  Eigen::Matrix<double, 6, 1> difference;
  difference.head<3>() = target.translation - at.translation;
  difference.tail<3>() = RotationVector(Eigen::Quaterniond(target.rotation * at.rotation.transpose()));
  return difference;
}

// The R-sequence (Roberts 2018): multiples of powers of 1 / ratio modulo 1, ratio the root of x^(n+1) = x + 1, which is
// the golden one for n = 1.
Eigen::VectorXd SpreadStart(const Chain& chain, int k, bool within_a_turn) {
  const int n = chain.num_joints();
  double ratio = 2.0;
  for (int i = 0; i < 60; ++i)  // each leaves less than half of what is wrong: all digits of a double
    ratio = std::pow(1.0 + ratio, 1.0 / (n + 1));
  Eigen::VectorXd start(n);
  for (int j = 0; j < n; ++j) {
    const Joint& joint = chain.joints[static_cast<size_t>(j)];
    const bool is_revolute = joint.type == JointType::kRevolute;
    const double half = is_revolute ? kPi : CharacteristicLength(chain);
    double low = joint.min.value_or(-half), high = joint.max.value_or(half);
    if (is_revolute && within_a_turn) low = std::max(low, -kPi), high = std::min(high, kPi);
    double share = 0.5 + k * std::pow(ratio, -(j + 1));
    share -= std::floor(share);
    start[j] = low + share * (high - low);
  }
  return start;
}

FlangeSolution SolveFlange(const Chain& chain, const FlangeFunction& arm, const Pose<double>& target,
                           const Eigen::VectorXd& start, bool within_limits) {
  FlangeSolution solution;
  solution.q = start;
  for (int j = 0; j < chain.num_joints(); ++j) {
    if (chain.joints[j].IsHeld()) solution.q[j] = *chain.joints[j].min;
  }
  Newton newton(chain, arm, target, solution.q);
  // Every round holds one more joint at its limit.
  for (int round = 0; round <= chain.num_joints(); ++round) {
    solution.status = TargetStatus::kOk;
    if (!newton.Run(&solution)) {
      solution.status = TargetStatus::kEquilibriumDiverged;
      return solution;
    }
    double limit = 0.0;
    const int worst = within_limits ? WorstJoint(chain, solution.q, &limit) : -1;
    if (worst < 0) break;
    solution.q[worst] = limit;
    solution.at_limit.push_back(worst);
    newton.Hold(worst);
  }
  const Eigen::Matrix<double, 6, 1> left = PoseDifference(target, solution.state.flange_in_base);
  solution.left_position = left.head<3>().norm();
  solution.left_rotation = left.tail<3>().norm();
  solution.least_singular = LeastSingularValue(chain, solution.state);
  if (solution.status == TargetStatus::kOk) solution.status = JudgeSolution(chain, solution);
  // Steps that do not settle next to a singularity are what a singularity does; far from the target the arm is
  // stretched out, which is singular too, and the target is out of reach.
  constexpr double kOutOfReach = 0.01;  // of the characteristic length; what compensation corrects is below 5 mm in 3 m
  if (solution.status == TargetStatus::kNotConverged && solution.least_singular < kNearSingular) {
    solution.status = solution.left_position > kOutOfReach * CharacteristicLength(chain) ? TargetStatus::kUnreachable
                                                                                         : TargetStatus::kSingular;
  }
  const bool is_there = solution.status == TargetStatus::kOk || solution.status == TargetStatus::kEquilibriumDiverged;
  if (!is_there && IsBeyondReach(chain, target.translation)) solution.status = TargetStatus::kUnreachable;
  return solution;
}

}  // namespace sagitta
