#include "models/denavit_hartenberg.h"

namespace sagitta {
namespace {

ElementaryTransform Fixed(Motion motion, Axis axis, double nominal, std::string error = "") {
  return {motion, axis, nominal, -1, 1.0, std::move(error)};
}

}  // namespace

std::string WordOf(DhConvention convention) {
  switch (convention) {
    case DhConvention::kStandard:
      return "standard";
    case DhConvention::kModified:
      return "modified";
  }
  return "";
}

void AppendDhLink(DhConvention convention, const DhLink& link, Chain* chain) {
  const Joint& joint = chain->joints[link.joint];
  const std::string prefix = joint.name + ".";
  ElementaryTransform theta = Fixed(Motion::kRotation, Axis::kZ, link.theta, prefix + "theta");
  ElementaryTransform d = Fixed(Motion::kTranslation, Axis::kZ, link.d, prefix + "d");
  const ElementaryTransform a = Fixed(Motion::kTranslation, Axis::kX, link.a, prefix + "a");
  const ElementaryTransform alpha = Fixed(Motion::kRotation, Axis::kX, link.alpha, prefix + "alpha");
  const ElementaryTransform beta = Fixed(Motion::kRotation, Axis::kY, link.beta, prefix + "beta");
  (joint.type == JointType::kRevolute ? theta : d).joint = link.joint;
  std::vector<ElementaryTransform> order;
  switch (convention) {
    case DhConvention::kStandard:
      order = {theta, d, a, alpha, beta};
      break;
    case DhConvention::kModified:
      order = {alpha, a, beta, theta, d};
      break;
  }
  chain->transforms.insert(chain->transforms.end(), order.begin(), order.end());
}

void AppendFixedPose(const Vector3<double>& xyz_m, const Vector3<double>& rpy_rad, Chain* chain) {
  for (int i = 0; i < 3; ++i) {
    if (xyz_m[i] != 0.0) chain->transforms.push_back(Fixed(Motion::kTranslation, static_cast<Axis>(i), xyz_m[i]));
  }
  for (int i = 2; i >= 0; --i) {  // R = Rz(yaw) Ry(pitch) Rx(roll)
    if (rpy_rad[i] != 0.0) chain->transforms.push_back(Fixed(Motion::kRotation, static_cast<Axis>(i), rpy_rad[i]));
  }
}

}  // namespace sagitta
