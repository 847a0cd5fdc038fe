// Effects that no entry of the catalogue describes.
#include <cmath>
#include <stdexcept>

#include "tests/hidden_effects/generator/hidden_effect.h"

namespace hidden {

int RevoluteJoint(const RobotKind& robot, Stream* random) {
  int j = 0;
  do {
    j = random->Below(robot.arm.size());
  } while (robot.arm.joints[j].prismatic);
  return j;
}

namespace {

constexpr double kTypicalAngle = 100e-6;  // rad
constexpr double kTypicalLength = 30e-6;  // m

int AnotherJoint(const RobotKind& robot, int joint, Stream* random) {
  int other = joint;
  while (other == joint) other = RevoluteJoint(robot, random);
  return other;
}

// Where most of the measured range lies.
double InnerAngle(const RobotKind& robot, int joint, Stream* random) {
  const JointLimits& limits = robot.arm.joints[joint];
  return limits.low + random->Uniform(0.25, 0.75) * (limits.high - limits.low);
}

}  // namespace

std::vector<std::string> OutsideKinds() { return {"bump", "product", "cross_harmonic", "time_wave", "step"}; }

HiddenEffect HideOutside(const std::string& kind, double scale, const RobotKind& robot, const Design&, Stream* random,
                         Nature* nature) {
  HiddenEffect effect;
  effect.kind = kind;
  effect.in_catalogue = false;
  const int j = RevoluteJoint(robot, random);
  const double size = scale * kTypicalAngle * random->Sign();
  effect.target = robot.arm.joints[j].name;
  if (kind == "bump") {
    const double centre = InnerAngle(robot, j, random), width = random->Uniform(0.1, 0.25);  // rad
    effect.words = "bump in q, half width " + std::to_string(1.177 * width) + " rad at " + std::to_string(centre);
    nature->encoder.push_back(
        {j, [=](const Shot& shot) { return size * std::exp(-0.5 * std::pow((shot.q[j] - centre) / width, 2)); }});
  } else if (kind == "product") {
    const int other = AnotherJoint(robot, j, random);
    effect.words = "product of " + effect.target + " and " + robot.arm.joints[other].name;
    nature->encoder.push_back({j, [=](const Shot& shot) { return size * shot.q[j] * shot.q[other]; }});
  } else if (kind == "cross_harmonic") {
    const int other = AnotherJoint(robot, j, random), order = 1 + random->Below(3);
    const double phase = random->Uniform(0.0, 6.283);
    effect.words = "period of " + robot.arm.joints[other].name + ", order " + std::to_string(order);
    nature->encoder.push_back({j, [=](const Shot& shot) { return size * std::cos(order * shot.q[other] + phase); }});
  } else if (kind == "time_wave") {
    const Vector3d move = scale * kTypicalLength * random->Direction();
    const double period = std::exp(random->Uniform(std::log(300.0), std::log(3000.0)));  // s
    const double phase = random->Uniform(0.0, 6.283);
    effect.target = "S1";
    effect.words = "period " + std::to_string(period) + " s";
    nature->shake = [=](const Shot& shot) -> Vector3d {
      if (shot.station != "S1") return Vector3d::Zero();
      return move * std::cos(6.283185307179586 * shot.time / period + phase);
    };
  } else if (kind == "step") {
    const double at = InnerAngle(robot, j, random);
    effect.words = "step in q at " + std::to_string(at) + " rad";
    nature->encoder.push_back({j, [=](const Shot& shot) { return shot.q[j] > at ? size : 0.0; }});
  } else {
    throw std::invalid_argument("no effect " + kind);
  }
  return effect;
}

}  // namespace hidden
