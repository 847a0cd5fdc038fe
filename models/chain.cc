#include "models/chain.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "models/constants.h"

namespace sagitta {

std::vector<std::string> JointNames(const std::vector<Joint>& joints) {
  std::vector<std::string> names;
  for (const Joint& joint : joints) names.push_back(joint.name);
  return names;
}

bool Joint::Allows(double value) const {
  // Half of the last digit of three decimals of degrees or mm, as controllers print, and of what is rounded after that.
  constexpr double kRoundedDegrees = 0.5001e-3 * kDegree, kRoundedMillimetres = 0.5001e-6;
  const double rounding = type == JointType::kRevolute ? kRoundedDegrees : kRoundedMillimetres;
  return !IsHeld() || std::abs(value - *min) <= rounding;
}

Chain::Chain() = default;
Chain::Chain(const Chain&) = default;
Chain::Chain(Chain&&) noexcept = default;
Chain& Chain::operator=(const Chain&) = default;
Chain& Chain::operator=(Chain&&) noexcept = default;
Chain::~Chain() = default;

int Chain::num_driven() const {
  return static_cast<int>(std::count_if(joints.begin(), joints.end(), [](const Joint& j) { return !j.IsHeld(); }));
}

int Chain::FindJoint(const std::string& name) const {
  for (int j = 0; j < num_joints(); ++j) {
    if (joints[j].name == name) return j;
  }
  return -1;
}

int Chain::FindError(const std::string& error) const {
  for (int e = 0; e < num_transforms(); ++e) {
    if (!error.empty() && transforms[e].error == error) return e;
  }
  return -1;
}

int Chain::JointTransform(int joint) const {
  for (int e = 0; e < num_transforms(); ++e) {
    if (transforms[e].joint == joint) return e;
  }
  return -1;
}

int Chain::AfterTiltSlots(int frame) const {
  while (frame < num_transforms() && transforms[frame].tilt_slot) ++frame;
  return frame;
}

Eigen::VectorXd Chain::CoupledJointValues(const Eigen::VectorXd& q) const {
  Eigen::VectorXd coupled = q;
  for (const Coupling& c : couplings) coupled[c.joint] += c.ratio * q[c.driver];
  return coupled;
}

std::string Chain::Defect() const {
  std::vector<int> carried(joints.size(), 0);
  std::set<std::string> errors;
  for (const ElementaryTransform& transform : transforms) {
    if (!transform.error.empty() && !errors.insert(transform.error).second) {
      return "the error name '" + transform.error + "' stands on two transforms";
    }
    if (!transform.has_joint()) continue;
    const Joint& joint = joints[transform.joint];
    ++carried[transform.joint];
    if (transform.is_rotation() != (joint.type == JointType::kRevolute)) {
      return "joint '" + joint.name + "' is " +
             (transform.is_rotation() ? "prismatic but turns" : "revolute but slides");
    }
  }
  for (int j = 0; j < num_joints(); ++j) {
    if (carried[j] == 0) return "joint '" + joints[j].name + "' is on no transform";
    if (carried[j] > 1) return "joint '" + joints[j].name + "' is on more than one transform";
  }
  return "";
}

}  // namespace sagitta
