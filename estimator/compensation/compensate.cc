#include "estimator/compensation/compensate.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "estimator/least_squares/parallel.h"
#include "estimator/report/compensation_words.h"
#include "estimator/statistics/distributions.h"
#include "models/constants.h"
#include "models/dense_algebra.h"
#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/range.h"
#include "problems/structure_failure.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Starts of the nominal inverse kinematics where a row states no joint values (SpreadStart). Newton reaches a solution
// from about every third start of a six-joint arm, so that all of them fail on a reachable pose once in 10^8.
constexpr int kKinematicStarts = 48;
// Degrees of freedom beyond which chi-square's skewness, sqrt(8 / nu), moves its quantiles by less than a thousandth of
// a standard deviation.
constexpr double kNextToNormal = 1e6;
// What an effect remembers is of the joint values that are commanded. A play operator of 1 deg changes by a tenth over
// the mrad that these differ from the nominal ones by; each round leaves some 4 % of that (300 urad over half a
// degree).
constexpr int kRoundsOfTheWay = 3;

// Columns of the estimate's parameters that act on the arm: index into names, index of the model's parameter.
struct ArmParameters {
  std::vector<int> model;
  std::vector<int> name;
};

// Columns of a station's base pose (BaseNames); -1: it is not uncertain.
std::array<int, 6> FindBase(const std::string& station, const std::vector<std::string>& names) {
  std::array<int, 6> columns;
  const std::array<std::string, 6> own = BaseNames(station);
  for (size_t k = 0; k < own.size(); ++k) {
    const auto found = std::find(names.begin(), names.end(), own[k]);
    columns[k] = found == names.end() ? -1 : static_cast<int>(found - names.begin());
  }
  return columns;
}

ArmParameters FindArmParameters(const ForwardModel& model, const std::vector<std::string>& names) {
  ArmParameters active;
  for (int i = 0; i < model.num_parameters(); ++i) {
    const auto found = std::find(names.begin(), names.end(), model.parameters()[i].name);
    if (found == names.end()) continue;
    active.model.push_back(i);
    active.name.push_back(static_cast<int>(found - names.begin()));
  }
  return active;
}

class Compensator {
 public:
  Compensator(const CompensationInput& input)
      : input_(input),
        nominal_model_(input.nominal),
        nominal_(nominal_model_, nominal_model_.NominalValues()),
        loaded_(input.problem.model(), input.problem.parameters.ModelValues()),
        shots_(input.problem.shot_inputs()),
        names_(input.uncertainty.Names()) {
    active_ = FindArmParameters(input.problem.model(), names_);
    for (const std::string& station : input.problem.data().stations) bases_.push_back(FindBase(station, names_));
  }

  FlangeSolution Nominal(const Target& target, const Eigen::VectorXd& previous) const;
  // Joint values of each target, on the way from one to the next. False: effects remember the same of it as before.
  bool SetWay(const std::vector<const Eigen::VectorXd*>& way);
  CompensatedTarget Compensate(int shot, const Target& target, const FlangeSolution& nominal) const;

 private:
  bool NominalAt(const Eigen::VectorXd& q, FlangeState* state) const {
    return nominal_.At(q, ShotInput(q), Matrix3<double>::Identity(), {}, state);
  }
  bool LoadedAt(int shot, const Eigen::VectorXd& q, const std::vector<int>& parameters, FlangeState* state) const {
    const int station = input_.problem.data().shots[shot].station;
    const Matrix3<double> base = input_.problem.parameters.BaseInStation(station).rotation;
    return loaded_.At(q, shots_[shot], base, parameters, state);
  }
  void AddUncertainty(int shot, const Pose<double>& goal, CompensatedTarget* result) const;
  void AddMotionOfMarkers(const FlangeState& state, Eigen::Matrix<double, 6, Eigen::Dynamic>* columns) const;
  void AddMotionOfBase(int shot, const FlangeState& state, Eigen::Matrix<double, 6, Eigen::Dynamic>* columns) const;
  double TurnOfRest(const FlangeState& state) const;
  std::string Words(const Target& target, const CompensatedTarget& result) const;
  std::string JointNames(const std::vector<int>& joints) const;

  const CompensationInput& input_;
  ForwardModel nominal_model_;
  LoadedArm nominal_, loaded_;
  std::vector<ShotInput> shots_;  // of the targets
  std::vector<std::string> names_;
  ArmParameters active_;
  std::vector<std::array<int, 6>> bases_;  // of each station
};

bool Compensator::SetWay(const std::vector<const Eigen::VectorXd*>& way) {
  const std::vector<ShotInput> before = shots_;
  for (size_t i = 0; i < way.size(); ++i) shots_[i].conditions.q = *way[i];
  input_.problem.model().Prepare(&shots_);
  const auto is_same = [](const ShotInput& a, const ShotInput& b) { return a.memory == b.memory; };
  return !std::equal(shots_.begin(), shots_.end(), before.begin(), is_same);
}

// Joint values of the nominal robot for a target: as stated, or by inverse kinematics from the joint values stated
// next to the pose, from the row before, and from many starts.
FlangeSolution Compensator::Nominal(const Target& target, const Eigen::VectorXd& previous) const {
  FlangeSolution solution;
  if (target.q && !target.flange_in_base) {
    solution.q = *target.q;
    solution.status = TargetStatus::kOk;
    NominalAt(solution.q, &solution.state);
    return solution;
  }
  const FlangeFunction arm = [this](const Eigen::VectorXd& q, FlangeState* state) { return NominalAt(q, state); };
  const auto good = [](const FlangeSolution& s) {
    return s.status == TargetStatus::kOk || s.status == TargetStatus::kSingular;
  };
  std::vector<Eigen::VectorXd> starts;
  if (target.q) starts.push_back(*target.q);
  if (!target.q && previous.size() > 0) starts.push_back(previous);
  for (int k = 0; !target.q && k < kKinematicStarts; ++k)
    starts.push_back(SpreadStart(input_.nominal, k, /*within_a_turn=*/false));
  FlangeSolution best;
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::VectorXd& start : starts) {
    solution = SolveFlange(input_.nominal, arm, *target.flange_in_base, start, true);
    const double left = solution.left_position / CharacteristicLength(input_.nominal) + solution.left_rotation;
    if (left < least) best = solution, least = left;
    if (good(solution)) return solution;
  }
  return best;
}

CompensatedTarget Compensator::Compensate(int shot, const Target& target, const FlangeSolution& nominal) const {
  CompensatedTarget result;
  const Pose<double> goal = target.flange_in_base.value_or(nominal.state.flange_in_base);
  FlangeState before;
  if (LoadedAt(shot, nominal.q, {}, &before)) {
    const Eigen::Matrix<double, 6, 1> off = PoseDifference(goal, before.flange_in_base);
    result.before_position = off.head<3>().norm();
    result.before_rotation = off.tail<3>().norm();
  }
  const FlangeFunction arm = [&](const Eigen::VectorXd& q, FlangeState* s) { return LoadedAt(shot, q, {}, s); };
  result.solution = SolveFlange(input_.problem.model().chain(), arm, goal, nominal.q, true);
  if (result.solution.status != TargetStatus::kEquilibriumDiverged) {
    FlangeState at;
    NominalAt(result.solution.q, &at);
    result.commanded = at.flange_in_base;
    AddUncertainty(shot, goal, &result);
  }
  result.words = Words(target, result);
  return result;
}

// J C J' + (J_h + J G) S (J_h + J G)' (prediction.h), the model error in C.
void Compensator::AddUncertainty(int shot, const Pose<double>& goal, CompensatedTarget* result) const {
  FlangeState state;
  if (!LoadedAt(shot, result->solution.q, active_.model, &state)) return;
  const ParameterUncertainty& known = input_.uncertainty;
  Eigen::Matrix<double, 6, Eigen::Dynamic> columns = Eigen::MatrixXd::Zero(6, names_.size());
  for (size_t i = 0; i < active_.name.size(); ++i) columns.col(active_.name[i]) = state.by_parameters.col(i);
  AddMotionOfMarkers(state, &columns);
  AddMotionOfBase(shot, state, &columns);
  const Eigen::MatrixXd estimated = columns.leftCols(known.estimated.size());
  Eigen::MatrixXd covariance = estimated * known.covariance * estimated.transpose();
  if (!known.held.empty()) {
    const Eigen::MatrixXd held = columns.rightCols(known.held.size()) + estimated * known.slopes;
    covariance += held * known.second_moment * held.transpose();
  }
  const Matrix3<double> position = covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix<double, 6, 1> off = PoseDifference(goal, state.flange_in_base);
  result->u95_position = Radius95(position + AddedByRest(position, input_.rest), off.head<3>(), input_.noise_dof);
  const Matrix3<double> rotation = covariance.bottomRightCorner<3, 3>();
  const Matrix3<double> left = AddedByRest(rotation, TurnOfRest(state));
  result->u95_rotation = Radius95(rotation + left, off.tail<3>(), input_.noise_dof);
}

// What the frame is off in which the markers stand (flange_of_markers.h), in the base's axes.
void Compensator::AddMotionOfMarkers(const FlangeState& state,
                                     Eigen::Matrix<double, 6, Eigen::Dynamic>* columns) const {
  const Matrix3<double>& rotation = state.flange_in_base.rotation;
  for (Eigen::Index i = 0; i < input_.flange.by_names.cols(); ++i) {
    columns->col(i).head<3>() += rotation * input_.flange.by_names.col(i).head<3>();
    columns->col(i).tail<3>() += rotation * input_.flange.by_names.col(i).tail<3>();
  }
}

// What the target's instrument sees is put into the base where the estimate has it, base_in_station = (R, t). Where
// that is off by dt and a turn v of its station's axes, a flange at p in the base is seen off by R'(dt + v x R p), R'v.
void Compensator::AddMotionOfBase(int shot, const FlangeState& state,
                                  Eigen::Matrix<double, 6, Eigen::Dynamic>* columns) const {
  const int station = input_.problem.data().shots[shot].station;
  const Matrix3<double> rotation = input_.problem.parameters.BaseInStation(station).rotation;
  const Vector3<double> arm = rotation * state.flange_in_base.translation;
  for (int k = 0; k < 6; ++k) {
    if (bases_[station][k] < 0) continue;
    const Vector3<double> unit = Vector3<double>::Unit(k % 3);
    auto column = columns->col(bases_[station][k]);
    column.head<3>() += rotation.transpose() * (k < 3 ? unit : Vector3<double>(unit.cross(arm)));
    if (k >= 3) column.tail<3>() += rotation.transpose() * unit;
  }
}

// rad: how far the flange is turned where all joints deviate alike, by so much that the markers are off by `rest`. What
// was left on unseen points is known as a distance alone.
double Compensator::TurnOfRest(const FlangeState& state) const {
  const Vector3<double> arm = state.flange_in_base.rotation * input_.flange.centre;
  double shift = 0.0, turn = 0.0;  // squares, of unit deviations
  for (Eigen::Index j = 0; j < state.by_joints.cols(); ++j) {
    const Vector3<double> about = state.by_joints.col(j).tail<3>();
    shift += (state.by_joints.col(j).head<3>() + about.cross(arm)).squaredNorm();
    turn += about.squaredNorm();
  }
  return shift > 0.0 ? input_.rest * std::sqrt(turn / shift) : 0.0;
}

std::string Compensator::JointNames(const std::vector<int>& joints) const {
  std::vector<std::string> names;
  for (const int joint : joints) names.push_back(input_.nominal.joints[joint].name);
  return Enumerate(names);
}

std::string Compensator::Words(const Target& target, const CompensatedTarget& result) const {
  const FlangeSolution& s = result.solution;
  const double position = s.left_position, rotation = s.left_rotation;
  switch (s.status) {
    case TargetStatus::kOk:
      if (input_.nominal.num_driven() < 6 && s.left_rotation > kOnTarget) {
        return OrientationLeft(input_.nominal.num_driven(), rotation);
      }
      return s.at_limit.empty() ? "" : LimitMadeUpFor(JointNames(s.at_limit));
    case TargetStatus::kSingular:
      return CloseToSingularity(position <= kOnTarget, position, rotation, s.least_singular);
    case TargetStatus::kLimit:
      return WouldLeaveLimits(JointNames(s.at_limit), position, rotation);
    case TargetStatus::kUnreachable:
      return OutOfReach(target.q.has_value(), position, rotation);
    case TargetStatus::kEquilibriumDiverged:
      return LoadFoldsArm();
    case TargetStatus::kNotConverged:
      return IterationUnsettled(position, rotation);
  }
  return "";
}

}  // namespace

double Radius95(const Matrix3<double>& covariance, const Vector3<double>& mean, double noise_dof) {
  const double trace = covariance.trace(), of_square = (covariance * covariance).trace();
  if (!std::isfinite(trace)) return std::numeric_limits<double>::quiet_NaN();
  if (!(trace > 0.0)) return mean.norm();
  double wider = 1.0;  // of the variances, for a noise that was found
  if (noise_dof > 0.0) {
    const double centred = trace * trace / of_square;
    wider = FQuantile(0.95, centred, noise_dof) / FQuantile(0.95, centred, kInfinity);
  }
  const double expected = wider * trace + mean.squaredNorm();
  const double variance = 2.0 * wider * wider * of_square + 4.0 * wider * mean.dot(covariance * mean);
  // Next to what is left for certain the rest is a normal number (freedom without bound).
  const double freedom = 2.0 * expected * expected / variance;
  if (freedom > kNextToNormal) return std::sqrt(expected + NormalQuantile(0.95) * std::sqrt(variance));
  return std::sqrt(expected * FQuantile(0.95, freedom, kInfinity));
}

namespace {

// A target without a shot stands nowhere, without pose and joint values it is none.
void CheckTargets(const CompensationInput& input, const std::vector<Target>& targets) {
  const size_t shots = input.problem.data().shots.size();
  if (targets.size() > shots) {
    throw InputError(
        {},
        std::to_string(targets.size()) + " targets and " + std::to_string(shots) + " shots: each target needs its own",
        "make the input of these targets (MakeCompensationInput)");
  }
  for (size_t i = 0; i < targets.size(); ++i) {
    const Target& target = targets[i];
    const std::string item = "target " + (target.name.empty() ? std::to_string(i) : target.name);
    if (!target.q && !target.flange_in_base) throw InputError({"", 0, item}, "it has neither a pose nor joint values");
    if (target.q && target.q->size() != input.nominal.num_joints()) {
      throw InputError({"", 0, item}, std::to_string(target.q->size()) + " joint values, the robot has " +
                                          std::to_string(input.nominal.num_joints()) + " joints");
    }
    if (target.q) CheckAreNumbers(*target.q, item, "a joint value");
    if (!target.flange_in_base) continue;
    CheckAreNumbers(target.flange_in_base->translation, item, "a coordinate of its pose");
    CheckIsRotation(target.flange_in_base->rotation, item, "the rotation of its pose");
  }
}

}  // namespace

std::vector<CompensatedTarget> Compensate(const CompensationInput& input, const std::vector<Target>& targets,
                                          int threads, const std::function<void(size_t done)>& progress) {
  CheckIn(allowed::kThreads, threads, "threads");
  CheckTargets(input, targets);
  Compensator compensator(input);
  // In their order: a path of poses stays on the branch it is on.
  std::vector<FlangeSolution> nominal(targets.size());
  Eigen::VectorXd previous;
  for (size_t i = 0; i < targets.size(); ++i) {
    CheckInterruption();
    nominal[i] = compensator.Nominal(targets[i], previous);
    if (nominal[i].status == TargetStatus::kOk) previous = nominal[i].q;
  }
  std::vector<CompensatedTarget> results(targets.size());
  std::vector<const Eigen::VectorXd*> way;
  for (const FlangeSolution& solution : nominal) way.push_back(&solution.q);
  const auto solve_all = [&] {
    std::atomic<size_t> done{0};
    ParallelFor(static_cast<int>(targets.size()), threads, [&](int i, int worker) {
      results[i] = compensator.Compensate(i, targets[i], nominal[i]);
      const size_t now = ++done;
      if (progress && worker == 0) progress(now);
    });
  };
  if (!input.problem.model().Remembers()) {
    solve_all();
    return results;
  }
  for (int round = 0; round < kRoundsOfTheWay; ++round) {
    if (!compensator.SetWay(way) && round > 0) break;
    solve_all();
    for (size_t i = 0; i < results.size(); ++i) way[i] = &results[i].solution.q;
  }
  return results;
}

}  // namespace sagitta
