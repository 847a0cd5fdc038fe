// What the four lists of causes outside the catalogue share (foreign.cc, strangers.cc, newcomers.cc, latecomers.cc).
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/hidden_effects/generator/hidden_effect.h"

namespace hidden {

constexpr double kTurn = 6.283185307179586;  // rad
constexpr double kTypicalAngle = 100e-6;     // rad
constexpr double kTypicalLength = 30e-6;     // m

// Target and shape of a cause are drawn from `random`; it is then added to `nature`, at `scale` times a typical size.
struct Draw {
  const RobotKind& robot;
  const Design& design;
  double scale;
  Stream* random;
  Nature* nature;
  HiddenEffect* effect;

  double LogUniform(double low, double high) const { return std::exp(random->Uniform(std::log(low), std::log(high))); }
  int Configurations() const { return design.shots.back().config + 1; }
  double Duration() const { return design.shots.back().since_first; }   // s
  double TypicalTorque() const { return robot.heavy.mass * kGravity; }  // N m at 1 m
  double Reach() const { return robot.heavy.mass > 50 ? 0.4 : 0.15; }   // m, of a link's centre of mass
  const std::string& Name(int joint) const { return robot.arm.joints[joint].name; }
  std::string Marker() const {
    const int number = random->Below(static_cast<int>(nature->markers.size()));
    return std::next(nature->markers.begin(), number)->first;
  }
  std::vector<int> RevoluteJoints() const {
    std::vector<int> joints;
    for (int j = 0; j < robot.arm.size(); ++j) {
      if (!robot.arm.joints[j].prismatic) joints.push_back(j);
    }
    return joints;
  }
  // Those that carry the arm.
  std::vector<int> MainAxes() const {
    std::vector<int> joints = RevoluteJoints();
    joints.resize(std::min<size_t>(3, joints.size()));
    return joints;
  }
};

// When the arm arrived, by configuration: s.
inline std::vector<double> Arrivals(const Design& design) {
  std::vector<double> times;
  for (const Shot& shot : design.shots) {
    if (shot.config == static_cast<int>(times.size())) times.push_back(shot.since_first);
  }
  return times;
}

inline Placement PlaceAt(const Arm& arm, const VectorXd& values) {
  Posture posture(arm.size());
  posture.values = values;
  return Place(arm, posture);
}

inline Placement PlaceAsCommanded(const Arm& arm, const Shot& shot) { return PlaceAt(arm, shot.q); }

// Of length 1.
inline Vector3d Horizontal(double heading) { return {std::cos(heading), std::sin(heading), 0.0}; }

// A force at a point, about a joint's axis: N m, base frame.
inline double TorqueOf(const Placement& placement, int joint, const Vector3d& at, const Vector3d& force) {
  return placement.axis[joint].dot((at - placement.after_joint[joint].origin).cross(force));
}

inline double AzimuthOf(const Vector3d& point) { return std::atan2(point.y(), point.x()); }

// By kind.
using Makers = std::vector<std::pair<std::string, void (*)(Draw)>>;

inline std::vector<std::string> KindsOf(const Makers& makers) {
  std::vector<std::string> kinds;
  for (const auto& maker : makers) kinds.push_back(maker.first);
  return kinds;
}

inline HiddenEffect HideOneOf(const Makers& makers, const std::string& kind, double scale, const RobotKind& robot,
                              const Design& design, Stream* random, Nature* nature) {
  for (const auto& [name, make] : makers) {
    if (name != kind) continue;
    HiddenEffect effect;
    effect.kind = kind;
    effect.in_catalogue = false;
    make({robot, design, scale, random, nature, &effect});
    return effect;
  }
  throw std::invalid_argument("no effect " + kind);
}

}  // namespace hidden
