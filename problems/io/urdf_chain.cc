#include "problems/io/urdf_chain.h"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "problems/input_error.h"
#include "problems/io/robot_checks.h"
#include "problems/io/robot_units.h"
#include "problems/io/urdf_numbers.h"
#include "problems/limits.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Movable = std::vector<std::string>;

// urdfdom reports through console_bridge, which prints unless it is given a handler.
class CollectedMessages : public console_bridge::OutputHandler {
 public:
  CollectedMessages() { console_bridge::useOutputHandler(this); }
  ~CollectedMessages() override { console_bridge::restorePreviousOutputHandler(); }

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_.empty()) first_ = text;
  }
  const std::string& first() const { return first_; }

 private:
  std::string first_;
};

// Two parents make a ring, in which the library leads on for ever.
void CheckOneParent(const urdf::ModelInterface& model, const std::string& file) {
  std::map<std::string, std::string> joint_above;  // by link
  for (const auto& [name, joint] : model.joints_) {
    const auto [entry, is_new] = joint_above.emplace(joint->child_link_name, name);
    if (is_new) continue;
    throw InputError({file, 0, joint->child_link_name},
                     "the link is the child of two joints, '" + entry->second + "' and '" + name + "'");
  }
}

// In an origin that is no comment.
bool StatesQuaternions(const std::string& text) {
  for (size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    if (text.compare(at, 4, "<!--") == 0) {
      at = std::min(text.find("-->", at), text.size());
      continue;
    }
    const std::string element = text.substr(at, text.find('>', at) - at);
    if (element.compare(0, 7, "<origin") == 0 && element.find("quat_xyzw") != std::string::npos) return true;
  }
  return false;
}

urdf::ModelInterfaceSharedPtr ParseModel(const std::string& text, const std::string& file,
                                         std::map<std::string, UrdfJointPlace>* places) {
  if (text.find("<xacro:") != std::string::npos) {
    throw InputError({file, 0, ""}, "this is a xacro file", "expand it first: xacro FILE.xacro > FILE.urdf");
  }
  CheckXml(text, file);
  if (StatesQuaternions(text)) {
    throw InputError({file, 0, "origin"}, "an origin states its rotation as quat_xyzw, which is not read here",
                     "state rpy=\"roll pitch yaw\" (rad)");
  }
  *places = CheckUrdfNumbers(text, file);
  CollectedMessages messages;
  urdf::ModelInterfaceSharedPtr model;
  std::string reason;
  try {
    model = urdf::parseURDF(WithPlainBlanks(text));
  } catch (const std::exception&) {
    reason = "a number or a name in it cannot be read";
  }
  if (model && model->links_.size() > limits::kLinks) {
    throw InputError({file, 0, ""}, "there are more than " + std::to_string(limits::kLinks) + " links");
  }
  if (model) {
    CheckOneParent(*model, file);
    return model;
  }
  if (reason.empty()) reason = messages.first();
  throw InputError({file, 0, ""}, "this is not a valid URDF" + (reason.empty() ? "" : ": " + reason));
}

Pose<double> PoseOfOrigin(const urdf::Pose& origin) {
  Pose<double> pose;
  pose.translation = {origin.position.x, origin.position.y, origin.position.z};
  const Eigen::Quaterniond rotation(origin.rotation.w, origin.rotation.x, origin.rotation.y, origin.rotation.z);
  pose.rotation = rotation.normalized().toRotationMatrix();
  return pose;
}

UrdfShape ShapeOf(const urdf::Collision& collision, const Pose<double>& chain_link_from_link) {
  UrdfShape shape;
  shape.link_from_shape = Product(chain_link_from_link, PoseOfOrigin(collision.origin));
  const urdf::Geometry* geometry = collision.geometry.get();
  if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(geometry)) {
    shape.kind = UrdfShape::Kind::kSphere;
    shape.size[0] = sphere->radius;
  } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(geometry)) {
    shape.kind = UrdfShape::Kind::kCylinder;
    shape.size.head<2>() << cylinder->radius, cylinder->length;
  } else if (const auto* box = dynamic_cast<const urdf::Box*>(geometry)) {
    shape.kind = UrdfShape::Kind::kBox;
    shape.size << box->dim.x, box->dim.y, box->dim.z;
  }
  return shape;
}

class ChainFinder {
 public:
  ChainFinder(const urdf::ModelInterface& model, std::string file) : model_(model), file_(std::move(file)) {}

  UrdfEnds Complete(UrdfEnds ends) const {
    if (ends.base_link.empty()) ends.base_link = model_.getRoot()->name;
    CheckLink("base_link", ends.base_link);
    if (ends.tip_link.empty()) ends.tip_link = OnlyTip(ends.base_link);
    CheckLink("tip_link", ends.tip_link);
    return ends;
  }

  // Links without a child beyond the base, but the tip.
  std::vector<std::string> OtherTips(const UrdfEnds& ends) const {
    std::vector<std::string> leaves;
    CollectLeaves(*model_.getLink(ends.base_link), 0, &leaves);
    leaves.erase(std::remove(leaves.begin(), leaves.end(), ends.tip_link), leaves.end());
    return leaves;
  }

  std::vector<UrdfJoint> Between(const UrdfEnds& ends) const {
    const auto up = ToRoot(ends.base_link), down = ToRoot(ends.tip_link);
    size_t shared = 0;  // joints next to the root that both pass
    while (shared < std::min(up.size(), down.size()) && up[up.size() - 1 - shared] == down[down.size() - 1 - shared]) {
      ++shared;
    }
    std::vector<UrdfJoint> joints;
    for (size_t i = 0; i + shared < up.size(); ++i) joints.push_back(Describe(*up[i], true));
    for (size_t i = down.size() - shared; i-- > 0;) joints.push_back(Describe(*down[i], false));
    return joints;
  }

  std::vector<UrdfLink> Links(const UrdfEnds& ends, const std::vector<UrdfJoint>& joints) const {
    std::vector<std::string> names = {ends.base_link};
    std::set<std::string> of_chain;
    for (const UrdfJoint& joint : joints) {
      const urdf::JointConstSharedPtr own = model_.getJoint(joint.name);
      names.push_back(joint.is_upward ? own->parent_link_name : own->child_link_name);
      of_chain.insert(joint.name);
    }
    std::vector<UrdfLink> links;
    for (const std::string& name : names) {
      links.push_back({name, {}, {}});
      CollectShapes(*model_.getLink(name), Pose<double>(), of_chain, 0, &links.back());
    }
    return links;
  }

 private:
  void CheckLink(const std::string& key, const std::string& link) const {
    if (model_.links_.count(link)) return;
    std::vector<std::string> names;
    for (const auto& [name, unused] : model_.links_) names.push_back(name);
    throw InputError({file_, 0, key}, "there is no link '" + link + "'", SpellingHint(link, names));
  }

  // Of the link and of those fixed to it by joints that are not of the chain, in the frame of the chain's link.
  void CollectShapes(const urdf::Link& link, const Pose<double>& chain_link_from_link,
                     const std::set<std::string>& of_chain, size_t depth, UrdfLink* into) const {
    if (depth > model_.joints_.size()) FailRing(link.name);
    for (const auto& collision : link.collision_array) {
      if (collision && collision->geometry) into->shapes.push_back(ShapeOf(*collision, chain_link_from_link));
    }
    for (const auto& joint : link.child_joints) {
      if (of_chain.count(joint->name) > 0) continue;
      if (joint->type != urdf::Joint::FIXED) {
        into->moving_beside.push_back(joint->child_link_name);
        continue;
      }
      CollectShapes(*model_.getLink(joint->child_link_name),
                    Product(chain_link_from_link, PoseOfOrigin(joint->parent_to_joint_origin_transform)), of_chain,
                    depth + 1, into);
    }
  }

  // Joints from the link up to the root.
  std::vector<urdf::JointConstSharedPtr> ToRoot(const std::string& link) const {
    std::vector<urdf::JointConstSharedPtr> joints;
    for (auto at = model_.getLink(link); at->parent_joint; at = at->getParent()) {
      joints.push_back(at->parent_joint);
      if (joints.size() > model_.joints_.size()) FailRing(link);
    }
    return joints;
  }

  Movable MovableJoints(const std::string& base, const std::string& tip) const {
    Movable names;
    for (const UrdfJoint& joint : Between({base, tip})) {
      if (!joint.is_fixed()) names.push_back(joint.name);
    }
    return names;
  }

  // `depth`: joints between the base and the link.
  void CollectLeaves(const urdf::Link& link, size_t depth, std::vector<std::string>* leaves) const {
    if (depth > model_.joints_.size()) FailRing(link.name);
    if (link.child_links.empty()) leaves->push_back(link.name);
    for (const auto& child : link.child_links) CollectLeaves(*child, depth + 1, leaves);
  }

  [[noreturn]] void FailRing(const std::string& link) const {
    throw InputError({file_, 0, link}, "the links are joined to a ring", "a chain has two ends");
  }

  // Of some joints those that follow no other.
  size_t NumDriven(const Movable& names) const {
    return std::count_if(names.begin(), names.end(),
                         [this](const auto& name) { return !model_.getJoint(name)->mimic; });
  }

  // The one link at the end of a branch with joints, branches aside that leave another on its way, which has more
  // joints beyond: one more that only follows may be a finger, or keep a flange level.
  std::string OnlyTip(const std::string& base) const {
    std::vector<std::string> leaves;
    CollectLeaves(*model_.getLink(base), 0, &leaves);
    std::vector<std::pair<std::string, Movable>> tips;
    for (const std::string& leaf : leaves) tips.emplace_back(leaf, MovableJoints(base, leaf));
    const auto is_side_branch = [&](const auto& tip) {
      return tip.second.empty() || std::any_of(tips.begin(), tips.end(), [&](const auto& other) {
               return other.second.size() > tip.second.size() && NumDriven(other.second) > NumDriven(tip.second) &&
                      std::equal(tip.second.begin(), tip.second.end(), other.second.begin());
             });
    };
    std::vector<std::string> candidates;
    for (const auto& tip : tips) {
      if (!is_side_branch(tip)) candidates.push_back(tip.first);
    }
    if (candidates.size() == 1) return candidates.front();
    if (candidates.empty()) {
      throw InputError({file_, 0, "base_link"}, "no joint that moves lies beyond the link '" + base + "'");
    }
    // Of an arm with a gripper most joints lie before the link where the fingers part; of a torso with two arms beyond.
    const std::string parting = WhereTheyPart(candidates);
    const size_t before = MovableJoints(base, parting).size(), all = MovableJoints(base, candidates.front()).size();
    if (before > 0) candidates.insert(2 * before > all ? candidates.begin() : candidates.end(), parting);
    std::vector<std::string> described;
    for (const std::string& tip : candidates) {
      described.push_back(tip + " (" + std::to_string(MovableJoints(base, tip).size()) + " joints)");
    }
    throw InputError({file_, 0, "tip_link"}, "beyond '" + base + "' the chain may end at any of: " + Joined(described),
                     "state it: kinematics: {urdf: {file: …, base_link: " + base + ", tip_link: " + candidates.front() +
                         "}}, or --base_link and --tip_link of 'sagitta convert'");
  }

  // The last link that the ways from the root to all of these pass.
  std::string WhereTheyPart(const std::vector<std::string>& tips) const {
    std::vector<std::string> shared;  // from the root on
    for (const std::string& tip : tips) {
      std::vector<std::string> way = {tip};
      for (const auto& joint : ToRoot(tip)) way.push_back(joint->parent_link_name);
      std::reverse(way.begin(), way.end());
      if (shared.empty()) shared = way;
      shared.erase(std::mismatch(shared.begin(), shared.end(), way.begin(), way.end()).first, shared.end());
    }
    return shared.back();
  }

  UrdfJoint Describe(const urdf::Joint& joint, bool is_upward) const {
    UrdfJoint result;
    result.name = joint.name;
    result.is_upward = is_upward;
    result.parent_from_joint = PoseOfOrigin(joint.parent_to_joint_origin_transform);
    if (joint.type == urdf::Joint::FIXED) return result;
    if (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS) {
      result.type = UrdfJoint::Type::kRevolute;
    } else if (joint.type == urdf::Joint::PRISMATIC) {
      result.type = UrdfJoint::Type::kPrismatic;
    } else {
      throw InputError({file_, 0, joint.name}, "the joint is floating or planar",
                       "a serial chain has revolute, continuous, prismatic and fixed joints");
    }
    result.axis = {joint.axis.x, joint.axis.y, joint.axis.z};
    if (!(result.axis.norm() > 1e-6)) throw InputError({file_, 0, joint.name}, "the joint's axis has no direction");
    result.axis.normalize();
    AddLimits(joint, &result);
    if (joint.mimic) result.mimic = {joint.mimic->joint_name, joint.mimic->multiplier, joint.mimic->offset};
    return result;
  }

  // Limits that are both 0 are the default of an attribute that is not there.
  void AddLimits(const urdf::Joint& joint, UrdfJoint* result) const {
    if (joint.type == urdf::Joint::CONTINUOUS || !joint.limits) return;
    if (joint.limits->lower == 0.0 && joint.limits->upper == 0.0) return;
    // Writers that know none state 1e16.
    const bool is_none = std::max(-joint.limits->lower, joint.limits->upper) > limits::kJointValue;
    if (is_none) return;
    if (!(joint.limits->lower < joint.limits->upper)) {
      throw InputError({file_, 0, joint.name}, "the limits of the joint are swapped or equal");
    }
    result->min = joint.limits->lower;
    result->max = joint.limits->upper;
  }

  const urdf::ModelInterface& model_;
  std::string file_;
};

// m and rad; a fixed joint before the first that moves may state where in a hall the robot stands.
void CheckUnits(const UrdfChain& chain, const std::map<std::string, UrdfJointPlace>& places, const std::string& file) {
  // Entities of a DTD within a name are expanded there and not by urdfdom: no place then.
  const auto place_of = [&](const UrdfJoint& joint) {
    const auto found = places.find(joint.name);
    return found == places.end() ? UrdfJointPlace() : found->second;
  };
  Pose<double> flange;  // in the first joint's frame, all joints at zero
  const UrdfJoint* longest = nullptr;
  bool has_moved = false;
  for (const UrdfJoint& joint : chain.joints) {
    const UrdfJointPlace place = place_of(joint);
    const InputError::Where where = {file, place.line, joint.name};
    const Pose<double>& origin = joint.parent_from_joint;
    for (int i = 0; i < 3; ++i)
      CheckRadians(place.rpy[i], std::string(std::array{"roll", "pitch", "yaw"}[i]) + " of its origin (rpy)", where);
    CheckLimitUnits(joint, where);
    if (has_moved) {
      flange = Product(flange, joint.is_upward ? Inverse(origin) : origin);
      if (!longest || origin.translation.norm() > longest->parent_from_joint.translation.norm()) longest = &joint;
    }
    has_moved |= !joint.is_fixed();
  }
  if (longest) CheckReach(flange.translation.norm(), {file, place_of(*longest).line, longest->name});
}

}  // namespace

UrdfChain ReadUrdfChain(const std::string& text, const std::string& file_in_messages, const UrdfEnds& ends) {
  std::map<std::string, UrdfJointPlace> places;
  const urdf::ModelInterfaceSharedPtr model = ParseModel(text, file_in_messages, &places);
  const ChainFinder finder(*model, file_in_messages);
  UrdfChain chain;
  chain.robot_name = model->getName();
  chain.ends = finder.Complete(ends);
  chain.other_tips = finder.OtherTips(chain.ends);
  chain.joints = finder.Between(chain.ends);
  chain.links = finder.Links(chain.ends, chain.joints);
  if (std::all_of(chain.joints.begin(), chain.joints.end(), [](const UrdfJoint& j) { return j.is_fixed(); })) {
    throw InputError({file_in_messages, 0, ""}, "no joint moves between the links '" + chain.ends.base_link +
                                                    "' and '" + chain.ends.tip_link + "'");
  }
  CheckUnits(chain, places, file_in_messages);
  return chain;
}

}  // namespace sagitta
