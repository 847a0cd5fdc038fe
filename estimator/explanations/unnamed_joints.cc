#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "estimator/explanations/candidates.h"
#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/unnamed_list.h"
#include "estimator/report/explanations_words.h"
#include "models/constants.h"
#include "models/single_motion.h"

namespace sagitta {
namespace {

constexpr int kWaveOrders = 6;  // of waves over another joint's angle, as of the catalogue's harmonics (candidates.cc)
constexpr size_t kJumps = 8;    // of which the prior has one part: the best ones, along a joint's angle, of all gaps
                                // between poses, kMostJointGaps at most
constexpr int kMostJointGaps = 200;  // of a turn one in 1.8 degrees
constexpr double kSame = 0.999;      // of the length of a mean of unit vectors: phases within 2.6 degrees
constexpr int kRipples = 6;          // of each joint, of all orders beyond the catalogue's that it may have
constexpr int kNeighbours = 2;       // joints that a hose or a table of corrections goes over lie that close

// s, a factor of four apart: no lag between them is off by more than two. What follows faster is there before it is
// measured, what follows slower creeps evenly through a campaign.
constexpr const char* kLagsOfJoints[] = {"300", "1200", "4800"};

class JointFunctions : public UnnamedList {
 public:
  JointFunctions(const CalibrationProblem& problem, const ParameterSet& parameters, EvidenceColumns* columns)
      : UnnamedList(problem, columns), parameters_(parameters), along_(columns->SumAlong(Joints())) {}

  std::vector<UnnamedGroup> List() {
    AddJointFunctions();
    AddAllJoints();
    AddRipple();
    AddPairs();
    AddSurfaces();
    AddLags();
    return Take();
  }

 private:
  static Source OfJoint(int j) { return {Source::Kind::kJoint, j, 0}; }

  std::vector<Source> Joints() const {
    std::vector<Source> sources;
    for (int j = 0; j < joints(); ++j) sources.push_back(OfJoint(j));
    return sources;
  }

  // A joint deviates with a driver.
  void AddJointFunctions() {
    const bool loaded = std::any_of(problem_.shot_inputs().begin(), problem_.shot_inputs().end(),
                                    [](const ShotInput& shot) { return !shot.wrenches.empty(); });
    const Eigen::MatrixXd torques = loaded ? JointTorques(problem_, parameters_) : Eigen::MatrixXd();
    const Driver time = TimeOf(problem_), temperature = TemperatureOf(problem_);
    for (int j = 0; j < joints(); ++j) {
      for (int k = 0; k < joints(); ++k) AddOverAngle(j, k);
      GroupedFunctions in_time, by_temperature, by_torque;
      if (Smooth(time.of_shot, "time", &in_time)) {
        AppendRamps(time.of_shot, kRamps, &in_time);
        AddDeviation(in_time, j, time, "time", "time", "time");
      }
      if (Smooth(temperature.of_shot, "smooth", &by_temperature)) {
        AddDeviation(by_temperature, j, temperature, "temperature", "temperature", "temperature");
      }
      if (!loaded) continue;
      const Driver torque = TorqueOf(problem_, j, torques);
      if (!Smooth(torque.of_shot, "smooth", &by_torque)) continue;
      AddDeviation(by_torque, j, torque, JointName(j), "the torque on it", "torque");
    }
  }

  void AddOverAngle(int j, int k) {
    GroupedFunctions functions;
    const Eigen::VectorXd q = JointValues(problem_, k);
    if (!Smooth(q, "smooth", &functions)) return;
    if (k == j) AppendBumps(q, "smooth", kFineBumps, &functions);
    if (k == j) AppendJumps(q, j, &functions);
    if (k != j && IsRevolute(problem_, k)) AppendWaves(q, k, &functions);
    AddDeviation(functions, j, AngleOf(problem_, k), JointName(k), JointName(k), k == j ? "own angle" : "other angle");
  }

  void AddDeviation(const GroupedFunctions& functions, int j, const Driver& driver, const std::string& depends_on,
                    const std::string& driver_in_words, const std::string& family) {
    AddFunctions(functions,
                 UnnamedFunction(JointName(j), {depends_on}, DeviatesWith(JointName(j), driver_in_words), {OfJoint(j)},
                                 {Over(driver, "learnt_deviation", JointName(j))}, driver),
                 family);
  }

  // Of the gaps between poses those that the rows say most of, each by itself.
  void AppendJumps(const Eigen::VectorXd& q, int j, GroupedFunctions* functions) const {
    Scan<Gap> scan;
    for (const TriedJump& jump : TryJumps(along_, fitted_, q, {kMostJointGaps, 1, j, 1}))
      scan.Try(jump.reduction, jump.gap);
    const std::vector<Gap> best = scan.Best(kJumps);
    const double unit = IsRevolute(problem_, j) ? kDegree : 1e-3;
    const double listed = static_cast<double>(best.size()) / static_cast<double>(scan.size());
    for (const Gap& gap : best) {
      functions->Append(
          Jump(q, gap), "step",
          {{"driver", JointName(j)}, {"from", AsSetting(gap.first / unit)}, {"to", AsSetting(gap.second / unit)}},
          "learnt_jump_deviation", listed);
    }
  }

  void AppendWaves(const Eigen::VectorXd& q, int driver, GroupedFunctions* functions) const {
    for (int n = 1; n <= kWaveOrders; ++n) {
      functions->Append(Wave(n * q), "periodic", {{"driver", JointName(driver)}, {"order", std::to_string(n)}},
                        "learnt_wave_deviation");
    }
  }

  // The heat of the drives: each joint deviates in its own way.
  void AddAllJoints() {
    const Driver time = TimeOf(problem_);
    GroupedFunctions functions;
    if (joints() < 2 || !Smooth(time.of_shot, "time", &functions)) return;
    UnnamedFunction what("joints", {"time"}, EachJointDeviatesWithTime(), Joints(), {}, time);
    for (int j = 0; j < joints(); ++j) what.effects.push_back(Over(time, "learnt_deviation", JointName(j)));
    AddFunctions(functions, what, "joints in time");
  }

  // What the effect does to its joint, in typical sizes; no column where its settings say nothing of these shots.
  Eigen::MatrixXd FunctionsOf(const EffectSpec& spec) const {
    const std::vector<ShotInput>& shots = problem_.shot_inputs();
    const auto motions = SingleMotionsOf(problem_.model().robot(), problem_.data().markers, spec, shots);
    if (!motions) return Eigen::MatrixXd(shots.size(), 0);
    Eigen::MatrixXd functions(static_cast<long>(shots.size()), motions->size());
    for (size_t k = 0; k < motions->size(); ++k) functions.col(k) = (*motions)[k].per_unit;
    if (!functions.allFinite()) functions.resize(functions.rows(), 0);  // a range that rounds to nothing
    return functions;
  }

  // The effect in units of the largest that the fitted shots have, with its function; null where all are zero.
  std::optional<std::pair<EffectSpec, GroupedFunctions>> Lagging(int j, const std::string& by,
                                                                 Settings settings) const {
    settings["by"] = by;
    settings["unit"] = "1";
    EffectSpec spec{"learnt_lag", JointName(j), settings, {}};
    const Eigen::MatrixXd own = FunctionsOf(spec);
    const double most = own.cols() > 0 ? OnFitted(own).cwiseAbs().maxCoeff() : 0.0;
    if (!(most > 0.0)) return std::nullopt;
    spec.settings["unit"] = AsSetting(most);
    GroupedFunctions functions;
    functions.Append(own / spec.NumberSetting("unit", 1.0), "time", {});
    return std::make_pair(spec, functions);
  }

  // Creep under what hangs on the arm, and the heat of the drives.
  void AddLags() {
    if (OrderOf(problem_).kind != DriverKind::kTime || !RangeOf(TimeOf(problem_).of_shot).Varies()) return;
    const Settings down = VectorSettings("down_", DownInBase(problem_, parameters_));
    const bool loaded = std::any_of(problem_.shot_inputs().begin(), problem_.shot_inputs().end(),
                                    [](const ShotInput& shot) { return !shot.conditions.load_wrenches.empty(); });
    for (const char* lag : kLagsOfJoints) {
      Settings settings = down;
      settings["lag_s"] = lag;
      AddLag(loaded ? "load" : "weight", TorqueOnIt(), settings);
      AddLag("motion", HeatOfItsMotion(), {{"lag_s", lag}});
    }
  }

  // One joint follows late; all of them, each in its own way.
  void AddLag(const std::string& by, const std::string& what, const Settings& settings) {
    UnnamedFunction each("joints", {"time"}, EachJointFollowsLate(what), {}, {});
    std::vector<GroupedFunctions> of_joints;
    for (int j = 0; j < joints(); ++j) {
      const auto own = Lagging(j, by, settings);
      if (!own) continue;
      const UnnamedFunction one(JointName(j), {"time"}, FollowsLate(JointName(j), what), {OfJoint(j)}, {own->first});
      AddFunctions(own->second, one, "lag");
      each.sources.push_back(OfJoint(j));
      each.effects.push_back(own->first);
      of_joints.push_back(own->second);
    }
    AddEach(of_joints, each, "joints in time");
  }

  // Orders d of which d q is the same at all poses, as on a lattice; up to `most`. Where phases scatter by v,
  // |mean exp(i phase)| = 1 - v / 2.
  static std::vector<bool> SameEverywhere(const Eigen::ArrayXd& q, int most) {
    std::vector<bool> same;
    const Eigen::ArrayXcd turn = Turn(q);
    Eigen::ArrayXcd wave = Eigen::ArrayXcd::Ones(q.size());
    for (int d = 0; d <= most; ++d, wave *= turn) same.push_back(std::abs(wave.mean()) > kSame);
    return same;
  }

  // Teeth beyond the orders of the catalogue: of many, those that the rows say most of, each joint by itself and
  // nothing else considered (they are as good as orthogonal to whatever is smooth); and for each order of the catalogue
  // one that these poses cannot distinguish from it, for all of them. The prior counts them all.
  void AddRipple() {
    const int first = ResolvedOrders(problem_) + 1, orders = kMostHarmonicOrders + 1 - first;
    for (int j = 0; j < joints(); ++j) {
      if (!IsRevolute(problem_, j) || orders < kRipples) continue;
      const Eigen::ArrayXd q = JointValues(problem_, j);
      // Waves of orders n and k are the same functions on these angles where (n - k) q or (n + k) q is the same.
      const std::vector<bool> same = SameEverywhere(OnFitted(q.matrix()).array(), kMostHarmonicOrders + first);
      const auto is_same = [&same](int order) { return same[order]; };
      std::map<int, std::pair<int, int>> aliases;  // by order of the catalogue: the lowest, and how many
      Scan<int> scan;
      const Eigen::ArrayXcd turn = Turn(q);
      Eigen::ArrayXcd wave = Turn(first * q);
      for (int n = first; n <= kMostHarmonicOrders; ++n, wave *= turn) {
        int k = 1;
        while (k < first && !is_same(n - k) && !is_same(n + k)) ++k;
        if (k < first) {
          ++aliases.emplace(k, std::make_pair(n, 0)).first->second.second;
        } else {
          scan.Try(along_.Reduction(wave.real(), j) + along_.Reduction(wave.imag(), j), n);
        }
      }
      const std::vector<int> best = scan.Best(kRipples);
      const double each = static_cast<double>(aliases.size() + best.size()) / orders;
      for (const int n : best) AddWave(j, n, each);
      for (const auto& [k, alias] : aliases) AddWave(j, alias.first, each * alias.second);
    }
  }

  void AddWave(int j, int order, double listed) {
    const std::string& name = JointName(j);
    const EffectSpec effect{"joint_harmonic", name, {{"order", std::to_string(order)}}, {}};
    GroupedFunctions functions;
    functions.Append(FunctionsOf(effect), "periodic", {}, "", listed);
    AddFunctions(functions, UnnamedFunction(name, {name}, RepeatsPerTurn(name, order), {OfJoint(j)}, {effect}),
                 "ripple");
  }

  // An effect over the ranges of two joints, on any joint.
  EffectSpec OverBoth(const std::string& name, int a, int b) const {
    const EffectSpec with = Over(AngleOf(problem_, b), name, "");
    EffectSpec effect = Over(AngleOf(problem_, a), name, "");
    effect.settings.erase("by");
    effect.settings["with"] = JointName(b);
    effect.settings["from_with"] = with.settings.at("from");
    effect.settings["to_with"] = with.settings.at("to");
    return effect;
  }

  // Of joint, driver and the other.
  using Words = std::string (*)(const std::string&, const std::string&, const std::string&);

  // Each of some joints deviates by two joints' angles together, as the effect on it does: by the same functions.
  void AddOfBoth(EffectSpec effect, const std::vector<int>& moved, Words words, const std::string& family) {
    const std::string driver = effect.settings.at("driver"), with = effect.settings.at("with");
    effect.target = JointName(moved[0]);
    const Eigen::MatrixXd own = FunctionsOf(effect);
    if (own.cols() == 0) return;
    GroupedFunctions functions;
    functions.Append(own, "other", {});
    for (const int j : moved) {
      effect.target = JointName(j);
      const std::string sentence = words(effect.target, driver, with);
      AddFunctions(functions, UnnamedFunction(effect.target, {driver, with}, sentence, {OfJoint(j)}, {effect}), family);
    }
  }

  // Of joints that move, the first one first.
  std::vector<std::pair<int, int>> Pairs() const {
    std::vector<std::pair<int, int>> pairs;
    const auto moves = [this](int j) { return RangeOf(JointValues(problem_, j)).Varies(); };
    for (int a = 0; a < joints(); ++a) {
      for (int b = a + 1; b < joints(); ++b) {
        if (moves(a) && moves(b)) pairs.emplace_back(a, b);
      }
    }
    return pairs;
  }

  // A joint deviates with two joints' angles together.
  void AddPairs() {
    std::vector<int> all(joints());
    std::iota(all.begin(), all.end(), 0);
    for (const auto& [a, b] : Pairs()) {
      AddOfBoth(OverBoth("learnt_product_deviation", a, b), all, DeviatesWithBoth, "two angles");
      const EffectSpec waves{"learnt_pair_deviation", "", {{"driver", JointName(a)}, {"with", JointName(b)}}, {}};
      if (IsRevolute(problem_, a) && IsRevolute(problem_, b)) AddOfBoth(waves, all, DeviatesWithBoth, "two angles");
    }
  }

  // A joint deviates over its own angle and a neighbour's.
  void AddSurfaces() {
    for (const auto& [a, b] : Pairs()) {
      EffectSpec surface = OverBoth("learnt_surface_deviation", a, b);
      surface.settings["knots"] = std::to_string(kUnnamedBumps[0]);
      if (b - a <= kNeighbours) AddOfBoth(surface, {a, b}, DeviatesOver, "surface");
    }
  }

  const ParameterSet& parameters_;
  const AlongSources along_;
};

}  // namespace

std::vector<UnnamedGroup> ListUnnamedJoints(const CalibrationProblem& problem, const ParameterSet& parameters,
                                            EvidenceColumns* columns) {
  return JointFunctions(problem, parameters, columns).List();
}

}  // namespace sagitta
