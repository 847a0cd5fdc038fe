#include "tests/hidden_effects/generator/arm.h"

#include <stdexcept>

namespace hidden {

int Arm::Find(const std::string& joint) const {
  for (int j = 0; j < size(); ++j) {
    if (joints[j].name == joint) return j;
  }
  throw std::invalid_argument("no joint " + joint);
}

const Element& Arm::ElementOf(int joint) const {
  for (const Element& element : elements) {
    if (element.joint == joint) return element;
  }
  throw std::invalid_argument("a joint without an element");
}

Matrix3d SmallTurn(const Vector3d& turn) {
  const double angle = turn.norm();
  if (angle == 0.0) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

namespace {

// The end of a link that bends about its middle.
void Bend(const Frame& start, const Vector3d& bend, Frame* end) {
  if (bend.isZero(0.0)) return;
  const Matrix3d turn = SmallTurn(start.turn * bend);
  const Vector3d middle = 0.5 * (start.origin + end->origin);
  end->origin = middle + turn * (end->origin - middle);
  end->turn = turn * end->turn;
}

}  // namespace

Placement Place(const Arm& arm, const Posture& posture) {
  Placement placement;
  placement.after_joint.resize(arm.size());
  placement.axis.resize(arm.size());
  Frame frame;
  frame.turn = SmallTurn(posture.foot);
  int link = 0;
  for (const Element& element : arm.elements) {
    const Vector3d unit = Vector3d::Unit(AxisNumber(element.move));
    double value = element.nominal + element.deviation;
    if (element.joint >= 0) {
      value += posture.values[element.joint];
      if (link > 0) Bend(placement.after_joint[link - 1], posture.bend[link - 1], &frame);
      link = element.joint + 1;
    } else if (!IsTurn(element.move)) {
      value *= 1.0 + posture.lengthening[link];
    }
    if (IsTurn(element.move)) {
      frame.turn = frame.turn * Eigen::AngleAxisd(value, unit).toRotationMatrix();
    } else {
      frame.origin += frame.turn * (value * unit);
    }
    if (element.joint < 0) continue;
    placement.axis[element.joint] = frame.turn * unit;
    frame.turn = frame.turn * SmallTurn(posture.tilt[element.joint]);
    placement.after_joint[element.joint] = frame;
  }
  placement.flange = frame;
  return placement;
}

}  // namespace hidden
