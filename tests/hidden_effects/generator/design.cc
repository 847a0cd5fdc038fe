#include "tests/hidden_effects/generator/design.h"

#include <cmath>

namespace hidden {
namespace {

constexpr double kOvershoot = 0.05;     // rad or m: a joint comes from this far
constexpr double kArmLag = 420.0;       // s, arm after air
constexpr double kWarmUp = 4000.0;      // s
constexpr double kSensorNoise = 0.03;   // K
constexpr double kLowestMarker = 0.15;  // m above the foot's plane

// Every configuration unloaded; the heavy load in two thirds, a sideways pull in
// the others, the light load in every fourth.
std::vector<LoadState> LoadsOf(const RobotKind& robot, int configuration, bool loaded) {
  std::vector<LoadState> loads = {{"none", 0.0, 0.0}};
  if (!loaded) return loads;
  const bool pulled = configuration % 3 == 2;
  if (!pulled) loads.push_back(robot.heavy);
  if (configuration % 4 == 1) loads.push_back(robot.light);
  if (pulled) loads.push_back(robot.sideways);
  return loads;
}

double Rounded(double value, double step) { return std::round(value / step) * step; }

// Joint values as a file can say them: 1e-9 degree, 1e-6 mm.
VectorXd DrawConfiguration(const RobotKind& robot, Stream* random) {
  const double degree = std::acos(-1.0) / 180.0;
  VectorXd q(robot.arm.size());
  for (int attempt = 0; attempt < 1000; ++attempt) {
    for (int j = 0; j < robot.arm.size(); ++j) {
      const JointLimits& limits = robot.arm.joints[j];
      const double value = random->Uniform(limits.low, limits.high);
      q[j] = limits.prismatic ? Rounded(value, 1e-9) : Rounded(value / degree, 1e-9) * degree;
    }
    Posture posture(robot.arm.size());
    posture.values = q;
    if (Place(robot.arm, posture).flange.origin.z() > kLowestMarker) break;
  }
  return q;
}

void Clock(double gap, double start_air, double rise, Stream* random, double* now, double* arm, Shot* shot) {
  *now = Rounded(*now + gap, 0.1);
  const double air = start_air + rise * (1.0 - std::exp(-*now / kWarmUp)) + 0.3 * std::sin(*now / 900.0);
  *arm += (air - *arm) * (1.0 - std::exp(-gap / kArmLag));
  shot->time = *now;
  shot->arm_temperature = *arm;
  shot->air = Rounded(air + random->Normal(kSensorNoise), 1e-3);
}

}  // namespace

Design MakeDesign(const RobotKind& robot, const DesignOptions& options, Stream* random) {
  Design design;
  design.options = options;
  double now = 0.0, arm_temperature = 20.0 + random->Uniform(0.0, 2.0);
  const double start_air = arm_temperature, rise = random->Uniform(4.0, 7.0);
  std::vector<double> first(options.stations, -1.0);
  for (int c = 0; c < options.configurations; ++c) {
    const VectorXd q = DrawConfiguration(robot, random);
    std::vector<int> approach(robot.arm.size());
    VectorXd turning = q;
    for (int j = 0; j < robot.arm.size(); ++j) {
      approach[j] = random->Chance(0.5) ? 1 : -1;
      turning[j] -= approach[j] * kOvershoot;
    }
    design.turning_points.push_back(turning);
    design.arrivals.push_back(q);
    bool arrives = true;
    for (const LoadState& load : LoadsOf(robot, c, options.loaded)) {
      Shot shot;
      shot.config = c;
      const int station = c * options.stations / options.configurations;
      shot.station = "S" + std::to_string(station + 1);
      shot.load = load.name;
      shot.q = q;
      shot.approach = approach;
      if (load.mass > 0.0) shot.force = {0.0, 0.0, -Rounded(load.mass * kGravity, 1e-3)};
      if (load.pull > 0.0) {
        const double direction = random->Uniform(0.0, 2.0 * std::acos(-1.0));
        shot.force = {Rounded(load.pull * std::cos(direction), 1e-3), Rounded(load.pull * std::sin(direction), 1e-3),
                      0.0};
      }
      for (int axis = 0; axis < 3; ++axis) shot.sigma[axis] = Rounded(random->Uniform(8e-6, 30e-6), 1e-8);
      Clock(arrives ? random->Uniform(60, 100) : random->Uniform(40, 90), start_air, rise, random, &now,
            &arm_temperature, &shot);
      arrives = false;
      if (first[station] < 0.0) first[station] = shot.time;
      shot.since_start = shot.time - first[station];
      shot.since_first = shot.time - (design.shots.empty() ? shot : design.shots.front()).time;
      design.shots.push_back(shot);
    }
  }
  return design;
}

}  // namespace hidden
