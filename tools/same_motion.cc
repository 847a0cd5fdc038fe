#include "tools/same_motion.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "models/effects/catalogue.h"
#include "models/forward_model.h"
#include "models/random_bits.h"

namespace sagitta {
namespace {

constexpr int kTrials = 200;  // shots of random values: what differs anywhere differs in nearly all of them

double Uniform(std::mt19937_64* random) { return 2.0 * UnitNumber((*random)()) - 1.0; }

Vector3<double> UniformVector(std::mt19937_64* random) {
  return Vector3<double>::NullaryExpr([random](Eigen::Index) { return Uniform(random); });
}

Eigen::VectorXd UniformJoints(const Chain& chain, std::mt19937_64* random) {
  Eigen::VectorXd q(chain.num_joints());
  for (double& value : q) value = Uniform(random);
  for (int j = 0; j < q.size(); ++j) q[j] *= chain.joints[j].type == JointType::kRevolute ? M_PI : 1.0;
  return q;
}

double FarthestApart(const Pose<double>& a, const Pose<double>& b) {
  double largest = 0.0;
  for (int i = 0; i < 3; ++i) {
    const Vector3<double> arm = Vector3<double>::Unit(i);
    largest = std::max(largest, (a * arm - b * arm).norm());
  }
  return largest;
}

// Shots of every kind: whatever an effect goes with varies. The load hangs on the flange.
std::vector<ShotInput> ShotsOfEveryKind(const Chain& chain, const EffectSpec& effect, std::uint64_t seed) {
  constexpr double kForce = 1000.0, kMoment = 100.0;  // N, N m
  constexpr double kKelvin = 5.0, kSeconds = 600.0;
  std::mt19937_64 random(seed);
  std::vector<ShotInput> shots;
  for (int trial = 0; trial < kTrials; ++trial) {
    ShotInput shot(UniformJoints(chain, &random));
    ShotConditions& conditions = shot.conditions;
    conditions.load = effect.target;  // of an effect on one load
    conditions.has_time = conditions.has_temperature = true;
    conditions.time = conditions.station_time = kSeconds * trial;
    conditions.temperature = kKelvin * Uniform(&random);
    for (int j = 0; j < chain.num_joints(); ++j) conditions.approach.push_back(random() % 2 == 0 ? 1 : -1);
    AppliedWrench load;
    load.frame = chain.FlangeFrame();
    load.point = 0.3 * UniformVector(&random);
    load.force = kForce * UniformVector(&random);
    load.moment = kMoment * UniformVector(&random);
    conditions.load_wrenches = {load};
    shot.wrenches = {load};
    shots.push_back(std::move(shot));
  }
  return shots;
}

// With one of its effects alone, what bends under loads included.
std::vector<Pose<double>> FlangesWith(Robot robot, size_t effect, std::uint64_t seed) {
  robot.effects = {EffectSpec(robot.effects[effect])};
  const ForwardModel model(robot);
  const Chain& chain = model.chain();  // what may tilt is a part of it
  std::vector<ShotInput> shots = ShotsOfEveryKind(chain, robot.effects.front(), seed);
  model.Prepare(&shots);
  const std::vector<double> values = model.NominalValues();
  std::vector<Pose<double>> flanges;
  for (const ShotInput& shot : shots) {
    flanges.push_back(model.FrameInBase(shot, values.data(), chain.FlangeFrame()));
  }
  return flanges;
}

bool MovesTheFlange(const Robot& robot, const EffectSpec& effect) {
  const EffectTarget target = FindEffect(robot, effect.effect)->target;
  return target != EffectTarget::kMarker && target != EffectTarget::kStation;
}

}  // namespace

double LargestDifference(const Chain& a, const Chain& b, std::uint64_t seed) {
  const ForwardModel models[2] = {ForwardModel(a), ForwardModel(b)};
  std::mt19937_64 random(seed);
  double largest = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::VectorXd q = UniformJoints(a, &random);
    Pose<double> flange[2];
    for (int m = 0; m < 2; ++m) {
      const std::vector<double> no_errors(models[m].num_parameters(), 0.0);
      ChainState<double> state;
      EvaluateChain(models[m].chain(), models[m].TransformValues(q, no_errors.data()).data(), &state);
      flange[m] = state.frames.back();
    }
    largest = std::max(largest, FarthestApart(flange[0], flange[1]));
  }
  return largest;
}

std::vector<EffectInOtherFrame> EffectsInOtherFrames(const Robot& read, const Robot& written, std::uint64_t seed) {
  constexpr double kSame =
      1e-8;  // m: what a fixed number of steps to the equilibrium leaves, and the text of the table
  std::vector<EffectInOtherFrame> other;
  for (size_t e = 0; e < read.effects.size(); ++e) {
    const EffectSpec& effect = read.effects[e];
    if (effect.values.empty() || !MovesTheFlange(read, effect)) continue;
    const std::vector<Pose<double>> before = FlangesWith(read, e, seed), after = FlangesWith(written, e, seed);
    double largest = 0.0;
    for (size_t k = 0; k < before.size(); ++k) largest = std::max(largest, FarthestApart(before[k], after[k]));
    if (largest > kSame) other.push_back({effect.Path(), largest});
  }
  return other;
}

}  // namespace sagitta
