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
constexpr double kSameSolution = 1e-5;  // rad or m, between two solutions: far above what a solve leaves (kOnTarget)
// rad: what a file states of an angle that is this close to the edge of a range, or to zero, is rounding of the pose
// (0.01 mm and 1e-6 of a quaternion are 1e-5 to 1e-4 rad). Solutions are 90 or 180 deg apart.
constexpr double kOnEdge = 0.1 * kDegree;
constexpr double kExact = 1e-6;  // rad: solutions within that of what is stated come first
// rad: beyond that a solution near the one that is stated may be another than the controller's.
constexpr double kNearStated = 45.0 * kDegree;
// rad: controllers are reported to disregard turn bits within that of 0.
constexpr double kTurnBitsCount = 2.0 * kDegree;
constexpr double kMeet = 1e-3;  // m, within which wrist axes count as meeting: of a robot as calibrated, by some 0.1 mm

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
    constexpr double h = 1e-6;  // rad: its square is off by 1e-12, rounding by 1e-10
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

// How far joint j is out of a range that is stated for it, rad; 0: it is not.
double OutOfRange(const StatedBranch& branch, int j, double value) {
  double out = 0.0;
  for (const auto& [index, range] : branch.ranges) {
    if (index == j) out = std::max({out, range.first - value, value - range.second});
  }
  return out;
}

double FarthestOut(const StatedBranch& branch, const Eigen::VectorXd& q) {
  double out = 0.0;
  for (int j = 0; j < q.size(); ++j) out = std::max(out, OutOfRange(branch, j, q[j]));
  return out;
}

// FANUC: "0, 0, 0" is read as every joint within half a turn; here as the turn numbers that it states.
StatedBranch WithTurns(StatedBranch branch, int joints) {
  const bool is_without = static_cast<int>(branch.ranges.size()) == joints &&
                          std::all_of(branch.ranges.begin(), branch.ranges.end(),
                                      [](const auto& range) { return range.second == std::make_pair(-kPi, kPi); });
  if (is_without) branch.ranges.clear(), branch.turns = {0, 0, 0};
  return branch;
}

std::vector<std::vector<int>> ThreesOf(int joints) {
  std::vector<std::vector<int>> threes;
  for (int a = 0; a < joints; ++a) {
    for (int b = a + 1; b < joints; ++b) {
      for (int c = b + 1; c < joints; ++c) threes.push_back({a, b, c});
    }
  }
  return threes;
}

// Branches with the turn numbers as ranges of joints: one, or one per three joints that the numbers may be of. The
// others stand within half a turn, or, others_turn, anywhere.
std::vector<StatedBranch> BranchesOf(const StatedBranch& branch, int joints, bool others_turn) {
  if (branch.turns.size() != 3) return {branch};
  std::vector<StatedBranch> branches;
  const bool is_stated = branch.turn_joints.size() == 3;
  for (const std::vector<int>& three :
       is_stated ? std::vector<std::vector<int>>{branch.turn_joints} : ThreesOf(joints)) {
    StatedBranch one = branch;
    for (int j = 0; j < joints; ++j) {
      const auto counted = std::find(three.begin(), three.end(), j);
      if (counted == three.end() && others_turn) continue;
      const int turn = counted == three.end() ? 0 : branch.turns[static_cast<size_t>(counted - three.begin())];
      one.ranges.push_back({j, {(2 * turn - 1) * kPi, (2 * turn + 1) * kPi}});
    }
    branches.push_back(one);
  }
  return branches;
}

// edge: rad, within which the sign of joint 5 is not determined.
bool Agrees(const ArmShape& shape, const StatedBranch& branch, double edge, const Eigen::VectorXd& q) {
  // Half a turn and more of joint 5 counts as below 0 (KUKA: status bit 2).
  const double flip = q.size() > 4 ? std::remainder(q[4], 2 * kPi) : 0.0;
  if (branch.wrist_negative && std::abs(flip) > edge && (flip < 0.0) != *branch.wrist_negative) return false;
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

// Of a wrist whose axes meet the three signs leave one solution.
bool StatesShape(const StatedBranch& branch) {
  return branch.wrist_negative && branch.wrist_behind && (branch.elbow_of_zero || branch.elbow_past_stretch);
}

// The solutions that agree with one of the branches. Those that do so but for rounding count where no other does.
class Agreeing {
 public:
  Agreeing(const Chain& chain, const ArmShape& shape, const std::vector<StatedBranch>& branches)
      : chain_(chain), shape_(shape), branches_(branches) {}

  void Add(const Eigen::VectorXd& solution) {
    for (const StatedBranch& branch : branches_) {
      Eigen::VectorXd q = solution;
      if (!TurnIntoRanges(chain_, branch, &q) || !Agrees(shape_, branch, kOnEdge, q)) continue;
      const bool is_exact = FarthestOut(branch, q) <= kExact && Agrees(shape_, branch, kExact, q);
      AddTo(is_exact ? &exact_ : &at_edge_, q);
    }
  }
  const std::vector<Eigen::VectorXd>& exact() const { return exact_; }
  const std::vector<Eigen::VectorXd>& found() const { return exact_.empty() ? at_edge_ : exact_; }

 private:
  static void AddTo(std::vector<Eigen::VectorXd>* list, const Eigen::VectorXd& q) {
    const bool is_new = std::none_of(list->begin(), list->end(),
                                     [&](const Eigen::VectorXd& other) { return (other - q).norm() < kSameSolution; });
    if (is_new) list->push_back(q);
  }

  const Chain& chain_;
  const ArmShape& shape_;
  const std::vector<StatedBranch>& branches_;
  std::vector<Eigen::VectorXd> exact_, at_edge_;
};

// Solutions of one pose by the nominal, rigid arm.
class PoseSolver {
 public:
  PoseSolver(const Chain& nominal, const Pose<double>& flange_in_base)
      : nominal_(nominal), flange_(flange_in_base), model_(nominal), rigid_(model_, model_.NominalValues()) {}

  FlangeSolution From(const Eigen::VectorXd& start, bool within_limits) const {
    const FlangeFunction arm = [&](const Eigen::VectorXd& q, FlangeState* state) {
      return rigid_.At(q, ShotInput(q), Matrix3<double>::Identity(), {}, state);
    };
    return SolveFlange(nominal_, arm, flange_, start, within_limits);
  }

  BranchFound NearBefore(const Eigen::VectorXd& before) const {
    if (before.size() == 0) return {{}, SolutionNotStated()};
    const FlangeSolution near = From(before, true);
    return IsOnTarget(near) ? BranchFound{near.q, ""} : BranchFound{{}, NoSolutionNearBefore()};
  }

  BranchFound NearStated(const std::vector<double>& stated) const {
    const Eigen::VectorXd start = Eigen::Map<const Eigen::VectorXd>(stated.data(), static_cast<int>(stated.size()));
    const FlangeSolution near = From(start, true);
    if (!IsOnTarget(near)) return {{}, NoSolutionNearStated()};
    const double off = (near.q - start).lpNorm<Eigen::Infinity>();
    return off <= kNearStated ? BranchFound{near.q, ""} : BranchFound{{}, StatedIsFarOff(off)};
  }

  BranchFound Configured(const StatedBranch& branch, const Eigen::VectorXd& before, bool others_turn) const;

 private:
  const Chain& nominal_;
  const Pose<double> flange_;
  const ForwardModel model_;
  const LoadedArm rigid_;
};

BranchFound PoseSolver::Configured(const StatedBranch& branch, const Eigen::VectorXd& before, bool others_turn) const {
  const ArmShape shape(nominal_);
  const std::vector<StatedBranch> branches = BranchesOf(branch, nominal_.num_joints(), others_turn);
  Agreeing agreeing(nominal_, shape, branches);
  // A path mostly stays on its branch: where there can be one solution only and the pose before leads to it, the
  // search over all starts would end there, too.
  if (before.size() > 0 && shape.is_known() && StatesShape(branch) && branches.size() == 1) {
    const FlangeSolution near = From(before, false);
    if (near.status == TargetStatus::kOk) agreeing.Add(near.q);
    if (!agreeing.exact().empty()) return {agreeing.exact()[0], ""};
  }
  bool reached = false;
  for (int k = 0; k < kSolutionStarts; ++k) {
    const FlangeSolution solution = From(SpreadStart(nominal_, k, /*within_a_turn=*/true), false);
    if (!IsOnTarget(solution)) continue;
    reached = true;
    agreeing.Add(solution.q);
    if (shape.is_known() && agreeing.found().size() == 1 && k > kSolutionStarts / 4)
      break;  // all three signs are determined: it is the one
  }
  const std::vector<Eigen::VectorXd>& found = agreeing.found();
  if (found.size() == 1) return {found[0], ""};
  if (found.size() > 1) return {{}, branches.size() > 1 ? TurnsInWords() : SolutionsAreSeveral(found.size())};
  return {{}, reached ? NoSolutionAsStated() : PoseOutOfReach()};
}

// A range of a whole turn is left for the one a turn away, anything else for the quadrant or the sign next to it.
bool IsLeftForGood(const StatedBranch& branch, int j, double value) {
  const double out = OutOfRange(branch, j, value);
  if (out > kTurnBitsCount) return true;
  return out > kExact && std::any_of(branch.ranges.begin(), branch.ranges.end(), [&](const auto& range) {
           return range.first == j && std::abs(range.second.second - range.second.first - 2 * kPi) < kExact;
         });
}

BranchKept KeptOf(const ArmShape& shape, const StatedBranch& branch, const Eigen::VectorXd& q) {
  BranchKept kept;
  kept.is_shape = Agrees(shape, branch, kExact, q);
  for (int j = 0; j < q.size(); ++j) {
    if (OutOfRange(branch, j, q[j]) > kExact) kept.out.push_back(j);
    kept.is_near &= !IsLeftForGood(branch, j, q[j]);
  }
  kept.is_near &= kept.is_shape;
  return kept;
}

}  // namespace

BranchFound FindBranch(const Chain& nominal, const Pose<double>& flange_in_base, const StatedBranch& branch,
                       const Eigen::VectorXd& before) {
  const PoseSolver solver(nominal, flange_in_base);
  if (!branch.near.empty()) return solver.NearStated(branch.near);
  if (branch.from_before || !branch.states_anything()) return solver.NearBefore(before);
  const BranchFound found = solver.Configured(branch, before, false);
  const StatedBranch counted = WithTurns(branch, nominal.num_joints());
  if (found.why_not != NoSolutionAsStated() || counted.turns.size() != 3) return found;
  // A joint beyond half a turn is one that is not counted: joint 3 of many arms.
  return solver.Configured(counted, before, true);
}

BranchKept KeepsBranch(const Chain& nominal, const StatedBranch& branch, const Eigen::VectorXd& meant,
                       const Eigen::VectorXd& q) {
  if (branch.from_before || !branch.states_anything()) return {};
  const ArmShape shape(nominal);
  const int joints = nominal.num_joints();
  // Which joints turn numbers are of is not known where several would have led to `meant`: all of them have to be kept.
  for (const bool others_turn : {false, true}) {
    std::vector<BranchKept> kept;
    for (const StatedBranch& one : BranchesOf(others_turn ? WithTurns(branch, joints) : branch, joints, others_turn)) {
      if (FarthestOut(one, meant) <= kOnEdge) kept.push_back(KeptOf(shape, one, q));
    }
    const auto rank = [](const BranchKept& k) { return 2 * k.is_near + k.is_exact(); };
    if (!kept.empty())
      return *std::min_element(kept.begin(), kept.end(),
                               [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  }
  return {};
}

}  // namespace sagitta
