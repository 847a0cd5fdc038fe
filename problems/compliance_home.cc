#include "problems/compliance_home.h"

#include <algorithm>
#include <vector>

#include "models/effects/catalogue.h"

namespace sagitta {
namespace {

bool HasPrior(const EffectSpec& spec) {
  return std::any_of(spec.prior_sigmas.begin(), spec.prior_sigmas.end(), [](double sigma) { return sigma > 0.0; });
}

// False: it stays an effect.
bool MoveHome(const EffectSpec& spec, Robot* robot) {
  const int joint = robot->chain.FindJoint(spec.target);
  const auto own = std::find_if(robot->compliances.begin(), robot->compliances.end(),
                                [&](const JointCompliance& c) { return c.joint == joint; });
  std::vector<JointCompliance::Node> nodes = {{0.0, 0.0}};
  if (own != robot->compliances.end()) nodes = own->nodes;
  for (JointCompliance::Node& node : nodes) node.k += spec.values[0];
  if (std::any_of(nodes.begin(), nodes.end(), [](const JointCompliance::Node& node) { return node.k < 0.0; })) {
    return false;
  }
  if (own != robot->compliances.end()) {
    own->nodes = nodes;
  } else {
    robot->compliances.push_back({joint, nodes, false});
  }
  return true;
}

}  // namespace

void MoveCompliancesHome(PriorOfCompliance prior, Robot* robot) {
  std::vector<EffectSpec> others;
  for (const EffectSpec& spec : robot->effects) {
    const bool may_move = prior == PriorOfCompliance::kIsDropped || !HasPrior(spec);
    if (!IsUseOf(JointComplianceEffect(), spec) || !may_move || !MoveHome(spec, robot)) others.push_back(spec);
  }
  robot->effects = others;
}

}  // namespace sagitta
