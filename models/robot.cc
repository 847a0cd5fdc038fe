#include "models/robot.h"

namespace sagitta {

Robot::Robot() = default;
Robot::Robot(const Robot&) = default;
Robot::Robot(Robot&&) noexcept = default;
Robot& Robot::operator=(const Robot&) = default;
Robot& Robot::operator=(Robot&&) noexcept = default;
Robot::~Robot() = default;

namespace {

// The table entry that `<joint>.<field>` names.
double* DhField(DhLink* link, const std::string& field) {
  if (field == "a") return &link->a;
  if (field == "alpha") return &link->alpha;
  if (field == "d") return &link->d;
  if (field == "theta") return &link->theta;
  if (field == "beta") return &link->beta;
  return nullptr;
}

}  // namespace

Chain ChainFromDhTable(const std::vector<Joint>& joints, const std::vector<Coupling>& couplings, const DhTable& table) {
  Chain chain;
  chain.joints = joints;
  chain.couplings = couplings;
  for (const DhLink& link : table.links) AppendDhLink(table.convention, link, &chain);
  AppendFixedPose(table.flange_xyz, table.flange_rpy, &chain);
  return chain;
}

Robot WithGeometricErrors(const Robot& robot, const std::map<std::string, double>& errors) {
  Robot result = robot;
  for (ElementaryTransform& transform : result.chain.transforms) {
    const auto found = errors.find(transform.error);
    if (found != errors.end()) transform.nominal += found->second;
  }
  if (!result.dh) return result;
  for (DhLink& link : result.dh->links) {
    const std::string prefix = robot.chain.joints[link.joint].name + ".";
    for (const char* field : {"a", "alpha", "d", "theta", "beta"}) {
      const auto found = errors.find(prefix + field);
      if (found != errors.end()) *DhField(&link, field) += found->second;
    }
  }
  return result;
}

}  // namespace sagitta
