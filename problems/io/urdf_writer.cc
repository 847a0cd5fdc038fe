#include "problems/io/urdf_writer.h"

#include <cmath>
#include <set>

#include "models/constants.h"
#include "models/kinematics.h"
#include "problems/input_error.h"
#include "problems/io/urdf_robot.h"
#include "problems/io/urdf_text.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr const char* kBaseLink = "base_link";
constexpr const char* kFlangeJoint = "flange_joint";
constexpr double kSameOrigin = 1e-12;  // m, rad: rounding of the products of a few poses
constexpr double kMostShift = 0.1;     // m: beyond any calibration
constexpr double kMostTurn = 10.0 * kDegree;

double TurnOf(const Matrix3<double>& rotation) { return Eigen::AngleAxisd(rotation).angle(); }

// base_from_frame of every frame at joint values 0.
std::vector<Pose<double>> FramesAtZero(const Chain& chain) {
  return NominalFrames(chain, Eigen::VectorXd::Zero(chain.num_joints()));
}

Vector3<double> MotionAxisOf(const ElementaryTransform& transform) {
  return transform.sign * Vector3<double>::Unit(static_cast<int>(transform.axis));
}

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  }
  return escaped;
}

std::string OriginElement(const Pose<double>& pose) {
  return "    <origin xyz=\"" + UrdfNumbers(pose.translation) + "\" rpy=\"" +
         UrdfNumbers(RpyFromRotation(pose.rotation)) + "\"/>\n";
}

std::string JointElement(const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const Pose<double>& origin, const std::string& rest) {
  return "  <joint name=\"" + Escaped(name) + "\" type=\"" + type + "\">\n    <parent link=\"" + Escaped(parent) +
         "\"/>\n    <child link=\"" + Escaped(child) + "\"/>\n" + OriginElement(origin) + rest + "  </joint>\n";
}

// The name, with as many underscores as it needs to be another than these.
std::string UnusedName(std::string name, const std::set<std::string>& used) {
  while (used.count(name) > 0) name += "_";
  return name;
}

std::set<std::string> JointNamesOf(const Chain& chain) {
  std::set<std::string> names;
  for (const Joint& joint : chain.joints) names.insert(joint.name);
  return names;
}

// Of the link that a joint moves: not the base's name, which a joint 'base' would give it.
std::string LinkNameOf(const Joint& joint) { return UnusedName(joint.name + "_link", {kBaseLink}); }

// Limits of a joint; effort and velocity are not known to a robot file.
std::string LimitElement(const Joint& joint) {
  std::string limit = "    <limit";
  if (joint.min && joint.max && !joint.IsHeld()) {
    limit += " lower=\"" + FormatNumber(*joint.min) + "\" upper=\"" + FormatNumber(*joint.max) + "\"";
  }
  return limit + " effort=\"0\" velocity=\"0\"/>\n";
}

// What moves a joint that does not move by itself; "" for all others. Throws InputError for what URDF has no words for.
std::string MimicElement(const Chain& chain, int j) {
  const Joint& joint = chain.joints[j];
  std::vector<Coupling> own;
  for (const Coupling& coupling : chain.couplings) {
    if (coupling.joint == j) own.push_back(coupling);
  }
  const auto fail = [&](const std::string& what, const std::string& hint) {
    throw InputError({"", 0, "coupling"}, "URDF cannot state that joint '" + joint.name + "' " + what, hint);
  };
  if (joint.IsHeld() && own.empty()) fail("is held", "leave its limits out, or make them a range");
  if (own.empty()) return "";
  if (own.size() > 1) fail("moves with two others", "");
  if (!joint.IsHeld() || *joint.min != 0.0)
    fail("moves by itself and with another", "where it only follows, its limits in the robot's file are 0 and 0");
  const Joint& driver = chain.joints[own.front().driver];
  if (driver.IsHeld()) fail("moves with '" + driver.name + "', which follows another", "");
  return "    <mimic joint=\"" + Escaped(driver.name) + "\" multiplier=\"" + FormatNumber(own.front().ratio) + "\"/>\n";
}

// Moves `base_from_old` by the least turn and shift so that its axis lies on the robot's.
Pose<double> MovedOntoAxis(const Pose<double>& base_from_old, const Vector3<double>& axis, bool revolute,
                           const Vector3<double>& direction, const Vector3<double>& point) {
  const Vector3<double> old_direction = base_from_old.rotation * axis;
  const Matrix3<double> turn = RotationBetween(old_direction, direction);
  Pose<double> moved{turn * base_from_old.rotation, base_from_old.translation};
  if (revolute) {
    const Vector3<double> away = base_from_old.translation - point;
    moved.translation = point + direction * direction.dot(away);
  }
  return moved;
}

class Editor {
 public:
  Editor(const UrdfChain& urdf, const Robot& robot, std::string file)
      : urdf_(urdf), chain_(robot.chain), frames_(FramesAtZero(chain_)), file_(std::move(file)) {
    CheckJoints();
  }

  std::map<std::string, OriginEdit> Edits() {
    Pose<double> here, old_here;  // base_from_link, after the joints so far
    int joint = -1;
    for (size_t i = 0; i < urdf_.joints.size(); ++i) {
      const UrdfJoint& step = urdf_.joints[i];
      old_here = Product(old_here, step.parent_from_joint);
      Pose<double> target = Product(here, step.parent_from_joint);
      const bool is_last = i + 1 == urdf_.joints.size();
      if (!step.is_fixed()) target = LinkFrame(++joint, step, old_here, is_last);
      if (step.is_fixed() && is_last) target = frames_.back();
      Add(step, Product(Inverse(here), target));
      here = Product(target, MimicOffset(step, 1.0));
      old_here = Product(old_here, MimicOffset(step, 1.0));
    }
    return edits_;
  }

 private:
  [[noreturn]] void Fail(const std::string& key, const std::string& what, const std::string& hint) const {
    throw InputError({file_, 0, key}, what, hint);
  }

  void CheckJoints() const {
    std::vector<const UrdfJoint*> movable;
    for (const UrdfJoint& joint : urdf_.joints) {
      if (!joint.is_fixed()) movable.push_back(&joint);
      if (joint.is_upward) Fail(joint.name, "the chain passes this joint from child to parent", "edit towards the tip");
    }
    if (static_cast<int>(movable.size()) != chain_.num_joints()) {
      Fail("",
           "the chain of this URDF has " + std::to_string(movable.size()) + " joints, the robot has " +
               std::to_string(chain_.num_joints()),
           "state its ends: --base_link, --tip_link");
    }
    size_t mimics = 0;
    for (size_t j = 0; j < movable.size(); ++j) {
      const bool revolute = movable[j]->type == UrdfJoint::Type::kRevolute;
      if (revolute != (chain_.joints[j].type == JointType::kRevolute)) {
        Fail(movable[j]->name, "the robot's joint '" + chain_.joints[j].name + "' is of the other type", "");
      }
      if (!movable[j]->mimic) continue;
      ++mimics;
      CheckMimic(static_cast<int>(j), *movable[j]);
    }
    if (mimics != chain_.couplings.size()) {
      Fail("", "the robot has couplings that this URDF does not have", "URDF states a coupling by <mimic>");
    }
  }

  void CheckMimic(int joint, const UrdfJoint& follower) const {
    for (const Coupling& coupling : chain_.couplings) {
      if (coupling.joint == joint && chain_.joints[coupling.driver].name == follower.mimic->driver &&
          coupling.ratio == follower.mimic->multiplier) {
        return;
      }
    }
    Fail(follower.name, "the robot has another coupling of this joint", "URDF states a coupling by <mimic>");
  }

  // base_from_link right after joint j at q = 0, without a mimic's offset, which the URDF adds itself.
  Pose<double> LinkFrame(int j, const UrdfJoint& joint, const Pose<double>& old_link, bool is_tip) const {
    const int e = chain_.JointTransform(j);
    const bool oblique = !ElementaryAxis(joint.axis);
    const Pose<double> without_offset = MimicOffset(joint, -1.0);
    if (chain_.FindError(joint.name + ".x") >= 0) return Product(frames_[e + (oblique ? 3 : 1)], without_offset);
    if (is_tip) return Product(CheckedTip(joint, e), without_offset);
    const bool revolute = joint.type == UrdfJoint::Type::kRevolute;
    const Vector3<double> direction = frames_[e].rotation * MotionAxisOf(chain_.transforms[e]);
    return MovedOntoAxis(old_link, joint.axis, revolute, direction, frames_[e].translation);
  }

  static Pose<double> MimicOffset(const UrdfJoint& joint, double times) {
    Pose<double> pose;
    if (!joint.mimic || joint.is_fixed()) return pose;
    const double offset = times * joint.mimic->offset;
    if (joint.type == UrdfJoint::Type::kRevolute) {
      pose.rotation = Eigen::AngleAxisd(offset, joint.axis).toRotationMatrix();
    } else {
      pose.translation = offset * joint.axis;
    }
    return pose;
  }

  // The flange itself, where it lies on the last axis as the URDF has it.
  Pose<double> CheckedTip(const UrdfJoint& joint, int e) const {
    const Pose<double>& flange = frames_.back();
    const Vector3<double> direction = frames_[e].rotation * MotionAxisOf(chain_.transforms[e]);
    const Vector3<double> away = flange.translation - frames_[e].translation;
    const bool parallel = (flange.rotation * joint.axis - direction).norm() < kSameOrigin;
    const bool on_line = joint.type == UrdfJoint::Type::kPrismatic || away.cross(direction).norm() < kSameOrigin;
    if (parallel && on_line) return flange;
    Fail(joint.name,
         "the link '" + urdf_.ends.tip_link + "' turns with this joint, and the robot's flange is not on its axis",
         "name a tip link behind a fixed joint: its origin can absorb the rest");
  }

  void Add(const UrdfJoint& joint, const Pose<double>& origin) {
    const Pose<double>& old = joint.parent_from_joint;
    const double shift = (origin.translation - old.translation).norm();
    const double turn = TurnOf(old.rotation.transpose() * origin.rotation);
    if (shift > kMostShift || turn > kMostTurn) {
      Fail(joint.name,
           "the origin would move by " + FormatNumber(std::round(1e4 * shift) / 10) + " mm and " +
               FormatNumber(std::round(10 * turn * 180 / M_PI) / 10) + " deg: this is another robot",
           "a robot that was calibrated from this URDF, with the same base and tip links, is expected");
    }
    OriginEdit edit;
    if (shift > kSameOrigin) edit.xyz = origin.translation;
    if (turn > kSameOrigin) edit.rpy = RpyFromRotation(origin.rotation);
    if (edit.xyz || edit.rpy) edits_[joint.name] = edit;
  }

  const UrdfChain& urdf_;
  const Chain& chain_;
  std::vector<Pose<double>> frames_;
  std::string file_;
  std::map<std::string, OriginEdit> edits_;
};

}  // namespace

std::string RobotToUrdf(const Robot& robot) {
  const Chain& chain = robot.chain;
  const std::vector<Pose<double>> frames = FramesAtZero(chain);
  const std::string fixed_joint = UnusedName(kFlangeJoint, JointNamesOf(chain));
  std::string links = std::string("  <link name=\"") + kBaseLink + "\"/>\n", joints, parent = kBaseLink;
  Pose<double> parent_frame;
  for (int j = 0; j < chain.num_joints(); ++j) {
    const int e = chain.JointTransform(j);
    const std::string child = LinkNameOf(chain.joints[j]);
    const bool revolute = chain.joints[j].type == JointType::kRevolute;
    const bool limited = chain.joints[j].min && chain.joints[j].max && !chain.joints[j].IsHeld();
    const std::string axis = "    <axis xyz=\"" + UrdfNumbers(MotionAxisOf(chain.transforms[e])) + "\"/>\n";
    joints += JointElement(chain.joints[j].name,
                           !revolute ? "prismatic"
                           : limited ? "revolute"
                                     : "continuous",
                           parent, child, Product(Inverse(parent_frame), frames[e + 1]),
                           axis + LimitElement(chain.joints[j]) + MimicElement(chain, j));
    links += "  <link name=\"" + Escaped(child) + "\"/>\n";
    parent = child;
    parent_frame = frames[e + 1];
  }
  joints += JointElement(fixed_joint, "fixed", parent, "flange", Product(Inverse(parent_frame), frames.back()), "");
  const std::string name = robot.name.empty() ? "robot" : robot.name;
  return "<?xml version=\"1.0\"?>\n<!-- effort and velocity 0: not known -->\n<robot name=\"" + Escaped(name) +
         "\">\n" + links + "  <link name=\"flange\"/>\n" + joints + "</robot>\n";
}

EditedUrdf EditUrdf(const std::string& text, const std::string& file_in_messages, const UrdfEnds& ends,
                    const Robot& robot) {
  const UrdfChain urdf = ReadUrdfChain(text, file_in_messages, ends);
  const std::map<std::string, OriginEdit> edits = Editor(urdf, robot, file_in_messages).Edits();
  EditedUrdf edited;
  edited.text = WithOrigins(text, file_in_messages, edits);
  for (const UrdfJoint& joint : urdf.joints) {
    if (edits.count(joint.name)) edited.joints.push_back(joint.name);
  }
  return edited;
}

}  // namespace sagitta
