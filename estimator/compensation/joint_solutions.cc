#include "estimator/compensation/joint_solutions.h"

#include <algorithm>
#include <cmath>

#include "estimator/report/compensation_words.h"
#include "models/constants.h"

namespace sagitta {
namespace {

// Newton from points spread over the joints' ranges (SpreadStart). From about one start in three it
// reaches a solution; of at most eight (sixteen) branches each then is missed once in 10^4 (10^2) after 240.
constexpr int kSolutionStarts = 240;
constexpr double kSameSolution = 1e-5;  // rad or m, between two solutions
constexpr double kOnEdge = 1e-6;        // rad: the sign of an angle this small is not determined
constexpr double kMeet = 1e-3;          // m, within which wrist axes count as meeting

// What is known of the arm's shape: wrist centre and where it lies, of six revolute joints with a spherical wrist.
class ArmShape {
 public:
  explicit ArmShape(const Chain& chain)
      : chain_(chain), model_(WithoutCouplings(chain)), arm_(model_, model_.NominalValues()) {
    if (chain.num_joints() != 6) return;
    for (const Joint& joint : chain.joints) {
      if (joint.type != JointType::kRevolute) return;
    }
    has_wrist_ = WristMeets();
    if (has_wrist_) forward_ = InFirstJoint(Eigen::VectorXd::Zero(6));
  }
  bool is_known() const { return has_wrist_; }

  // Behind joint 1: on the other side of its axis than at the zero pose.
  bool IsBehind(const Eigen::VectorXd& q) const {
    return InFirstJoint(chain_.CoupledJointValues(q)).dot(forward_) < 0.0;
  }
  // d |wrist - joint 2|^2 / d q3: its sign is the side to which the elbow is bent, 0 where the arm is stretched.
  double ElbowSlope(const Eigen::VectorXd& q) const {
    constexpr double h = 1e-6;
    const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(6, 2);
    const Eigen::VectorXd moved = chain_.CoupledJointValues(q);
    return (ReachSquared(moved + step) - ReachSquared(moved - step)) / (2 * h);
  }

 private:
  static Chain WithoutCouplings(Chain chain) {
    chain.couplings.clear();
    return chain;
  }
  // A point on the axis of a joint and its direction, in the base: from the flange's motion v = z x (p - o).
  struct Line {
    Vector3<double> point, direction;
  };
  Line AxisOf(const Eigen::VectorXd& q, int joint) const {
    FlangeState state;
    arm_.At(q, ShotInput(q), Matrix3<double>::Identity(), {}, &state);
    const Vector3<double> v = state.by_joints.block<3, 1>(0, joint), z = state.by_joints.block<3, 1>(3, joint);
    return {state.flange_in_base.translation + z.cross(v) / z.squaredNorm(), z.normalized()};
  }
  // Foot of the common perpendicular of two lines, on the first.
  static Vector3<double> Foot(const Line& a, const Line& b) {
    const Vector3<double> n = a.direction.cross(b.direction), gap = b.point - a.point;
    const double t = gap.cross(b.direction).dot(n) / n.squaredNorm();
    return a.point + t * a.direction;
  }
  Vector3<double> Wrist(Eigen::VectorXd q) const {
    if (std::abs(std::sin(q[4])) < 0.1) q[4] += 1.0;  // turning joint 5 does not move it
    return Foot(AxisOf(q, 3), AxisOf(q, 5));
  }
  bool WristMeets() const {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(6);
    q[4] = 1.0;
    const Line a = AxisOf(q, 3), b = AxisOf(q, 4), c = AxisOf(q, 5);
    if (a.direction.cross(c.direction).norm() < 1e-3) return false;
    const Vector3<double> wrist = Foot(a, c);
    const auto off = [&](const Line& line) { return (wrist - line.point).cross(line.direction).norm(); };
    return off(b) < kMeet && off(c) < kMeet;
  }
  // Of the wrist, perpendicular to axis 1, as if joint 1 stood at zero.
  Vector3<double> InFirstJoint(Eigen::VectorXd q) const {
    q[0] = 0.0;
    const Line axis = AxisOf(q, 0);
    const Vector3<double> arm = Wrist(q) - axis.point;
    return arm - arm.dot(axis.direction) * axis.direction;
  }
  double ReachSquared(const Eigen::VectorXd& q) const {
    const Line shoulder = AxisOf(q, 1);
    const Vector3<double> arm = Wrist(q) - shoulder.point;
    return (arm - arm.dot(shoulder.direction) * shoulder.direction).squaredNorm();
  }

  const Chain& chain_;
  ForwardModel model_;  // of joints as they turn, couplings counted
  LoadedArm arm_;
  bool has_wrist_ = false;
  Vector3<double> forward_;
};

bool IsWithin(const Joint& joint, double value) {
  return value >= joint.min.value_or(-1e300) - 1e-9 && value <= joint.max.value_or(1e300) + 1e-9;
}

// Whole turns that put joints into the ranges stated for them; of several the smallest angle. False: there is none.
bool TurnIntoRanges(const Chain& chain, const StatedBranch& branch, Eigen::VectorXd* q) {
  for (int j = 0; j < q->size(); ++j) {
    const Joint& joint = chain.joints[static_cast<size_t>(j)];
    if (joint.type != JointType::kRevolute) continue;
    double low = -1e300, high = 1e300;
    for (const auto& [index, range] : branch.ranges) {
      if (index == j) low = range.first - kOnEdge, high = range.second + kOnEdge;
    }
    const double principal = std::remainder((*q)[j], 2 * kPi);
    double best = std::nan("");
    for (const int turn : {0, 1, -1, 2, -2}) {
      const double value = principal + 2 * kPi * turn;
      if (value < low || value > high || !IsWithin(joint, value)) continue;
      if (!(std::abs(best) <= std::abs(value))) best = value;
    }
    if (std::isnan(best)) return false;
    (*q)[j] = best;
  }
  return true;
}

// Branches with the turn numbers as ranges of joints: one, or one per three joints that the numbers may be of.
std::vector<StatedBranch> BranchesOf(const StatedBranch& branch, int joints) {
  if (branch.turns.size() != 3) return {branch};
  std::vector<std::vector<int>> threes;
  if (branch.turn_joints.size() == 3) {
    threes.push_back(branch.turn_joints);
  } else {
    for (int a = 0; a < joints; ++a) {
      for (int b = a + 1; b < joints; ++b) {
        for (int c = b + 1; c < joints; ++c) threes.push_back({a, b, c});
      }
    }
  }
  std::vector<StatedBranch> branches;
  for (const std::vector<int>& three : threes) {
    StatedBranch one = branch;
    for (int j = 0; j < joints; ++j) {
      const auto counted = std::find(three.begin(), three.end(), j);
      const int turn = counted == three.end() ? 0 : branch.turns[static_cast<size_t>(counted - three.begin())];
      one.ranges.push_back({j, {(2 * turn - 1) * kPi, (2 * turn + 1) * kPi}});
    }
    branches.push_back(one);
  }
  return branches;
}

bool Agrees(const ArmShape& shape, const StatedBranch& branch, const Eigen::VectorXd& q) {
  // Half a turn and more of joint 5 counts as below 0 (KUKA: status bit 2).
  const double flip = q.size() > 4 ? std::remainder(q[4], 2 * kPi) : 0.0;
  if (branch.wrist_negative && std::abs(flip) > kOnEdge && (flip < 0.0) != *branch.wrist_negative) return false;
  if (!shape.is_known()) return true;
  if (branch.wrist_behind && shape.IsBehind(q) != *branch.wrist_behind) return false;
  const double slope = shape.ElbowSlope(q);
  if (branch.elbow_past_stretch && (slope < 0.0) != *branch.elbow_past_stretch) return false;
  const double at_zero = branch.elbow_of_zero ? shape.ElbowSlope(Eigen::VectorXd::Zero(6)) : 0.0;
  return !branch.elbow_of_zero || (slope * at_zero > 0.0) == *branch.elbow_of_zero;
}

bool IsOnTarget(const FlangeSolution& solution) {
  return solution.status == TargetStatus::kOk || solution.status == TargetStatus::kSingular;
}

}  // namespace

BranchFound FindBranch(const Chain& nominal, const Pose<double>& flange_in_base, const StatedBranch& branch,
                       const Eigen::VectorXd& before) {
  const ArmShape shape(nominal);
  const ForwardModel model(nominal);
  const LoadedArm rigid(model, model.NominalValues());
  const FlangeFunction arm = [&](const Eigen::VectorXd& q, FlangeState* state) {
    return rigid.At(q, ShotInput(q), Matrix3<double>::Identity(), {}, state);
  };
  if (branch.from_before || !branch.states_anything()) {
    if (before.size() == 0) {
      return {{}, SolutionNotStated()};
    }
    const FlangeSolution near = SolveFlange(nominal, arm, flange_in_base, before, true);
    if (IsOnTarget(near)) return {near.q, ""};
    return {{}, NoSolutionNearBefore()};
  }
  const std::vector<StatedBranch> branches = BranchesOf(branch, nominal.num_joints());
  std::vector<Eigen::VectorXd> found;
  bool reached = false;
  for (int k = 0; k < kSolutionStarts; ++k) {
    const FlangeSolution solution =
        SolveFlange(nominal, arm, flange_in_base, SpreadStart(nominal, k, /*within_a_turn=*/true), false);
    if (!IsOnTarget(solution)) continue;
    reached = true;
    for (const StatedBranch& one : branches) {
      Eigen::VectorXd q = solution.q;
      if (!TurnIntoRanges(nominal, one, &q) || !Agrees(shape, one, q)) continue;
      const bool is_new = std::none_of(
          found.begin(), found.end(), [&](const Eigen::VectorXd& other) { return (other - q).norm() < kSameSolution; });
      if (is_new) found.push_back(q);
    }
    if (shape.is_known() && found.size() == 1 && k > kSolutionStarts / 4)
      break;  // all three signs are determined: it is the one
  }
  if (found.size() == 1) return {found[0], ""};
  if (found.size() > 1 && branches.size() > 1) {
    return {{}, TurnsInWords()};
  }
  if (found.size() > 1) {
    return {{}, SolutionsAreSeveral(found.size())};
  }
  return {{}, reached ? NoSolutionAsStated() : PoseOutOfReach()};
}

}  // namespace sagitta
