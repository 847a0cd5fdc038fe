#include "problems/io/urdf_robot.h"

#include <cmath>

#include "problems/input_error.h"
#include "problems/io/files.h"

namespace sagitta {
namespace {

constexpr const char* kTiltNames[] = {".roll", ".pitch", ".yaw"};

ElementaryTransform Fixed(Motion motion, int axis, double nominal, const std::string& error = "") {
  return {motion, static_cast<Axis>(axis), nominal, -1, 1.0, error};
}

void AppendRotation(const Matrix3<double>& rotation, Chain* chain) {
  const Vector3<double> rpy = RpyFromRotation(rotation);
  for (int i = 2; i >= 0; --i) {
    if (rpy[i] != 0.0) chain->transforms.push_back(Fixed(Motion::kRotation, i, rpy[i]));
  }
}

void AppendTranslationWithErrors(const Vector3<double>& xyz, const std::string& joint, Chain* chain) {
  for (int i = 0; i < 3; ++i) {
    chain->transforms.push_back(Fixed(Motion::kTranslation, i, xyz[i], joint + "." + "xyz"[i]));
  }
}

// The tilts of the joint frame, without that about `own` (-1: all three).
void AppendTilts(const std::string& joint, int own, Chain* chain) {
  for (int i = 0; i < 3; ++i) {
    if (i != own) chain->transforms.push_back(Fixed(Motion::kRotation, i, 0.0, joint + kTiltNames[i]));
  }
}

class ChainBuilder {
 public:
  void Append(const UrdfJoint& joint) {
    if (joint.is_fixed()) {
      const Pose<double> pose = joint.is_upward ? Inverse(joint.parent_from_joint) : joint.parent_from_joint;
      AppendFixedPose(pose.translation, RpyFromRotation(pose.rotation), &chain_);
      return;
    }
    const bool revolute = joint.type == UrdfJoint::Type::kRevolute;
    chain_.joints.push_back(
        {joint.name, revolute ? JointType::kRevolute : JointType::kPrismatic, joint.min, joint.max});
    if (joint.mimic) chain_.joints.back().min = chain_.joints.back().max = 0.0;  // in addition to what it mimics
    const std::optional<SignedAxis> elementary = ElementaryAxis(joint.axis);
    const int own = revolute && elementary ? static_cast<int>(elementary->axis) : -1;
    if (!joint.is_upward) {
      AppendTranslationWithErrors(joint.parent_from_joint.translation, joint.name, &chain_);
      AppendRotation(joint.parent_from_joint.rotation, &chain_);
      AppendTilts(joint.name, own, &chain_);
      AppendMotion(joint, elementary);
    } else {
      const Pose<double> joint_from_parent = Inverse(joint.parent_from_joint);
      AppendMotion(joint, elementary);
      AppendTilts(joint.name, own, &chain_);
      AppendTranslationWithErrors(joint_from_parent.translation, joint.name, &chain_);
      AppendRotation(joint_from_parent.rotation, &chain_);
    }
  }

  Chain chain() && { return std::move(chain_); }

 private:
  void AppendMotion(const UrdfJoint& joint, const std::optional<SignedAxis>& elementary) {
    const bool revolute = joint.type == UrdfJoint::Type::kRevolute;
    const double way = joint.is_upward ? -1.0 : 1.0;
    ElementaryTransform motion;
    motion.motion = revolute ? Motion::kRotation : Motion::kTranslation;
    motion.joint = chain_.num_joints() - 1;
    motion.axis = elementary ? elementary->axis : Axis::kZ;
    motion.sign = way * (elementary ? elementary->sign : 1.0);
    if (joint.mimic) motion.nominal = motion.sign * joint.mimic->offset;
    if (elementary) {
      if (revolute) motion.error = joint.name + kTiltNames[static_cast<int>(motion.axis)];
      chain_.transforms.push_back(motion);
      return;
    }
    // An oblique axis a: Rz(azimuth) Ry(polar) turns z into it, and back after the motion.
    const double azimuth = std::atan2(joint.axis.y(), joint.axis.x());
    const double polar = std::atan2(joint.axis.head<2>().norm(), joint.axis.z());
    chain_.transforms.push_back(Fixed(Motion::kRotation, 2, azimuth));
    chain_.transforms.push_back(Fixed(Motion::kRotation, 1, polar));
    chain_.transforms.push_back(motion);
    chain_.transforms.push_back(Fixed(Motion::kRotation, 1, -polar));
    chain_.transforms.push_back(Fixed(Motion::kRotation, 2, -azimuth));
  }

  Chain chain_;
};

Coupling CouplingOf(const UrdfChain& urdf, const UrdfJoint& follower, const Chain& chain, const std::string& file) {
  const auto fail = [&](const std::string& why) {
    throw InputError({file, 0, follower.name}, "the joint mimics '" + follower.mimic->driver + "', " + why,
                     "describe the coupling in a robot.yaml with its own chain");
  };
  Coupling coupling;
  coupling.joint = chain.FindJoint(follower.name);
  coupling.driver = chain.FindJoint(follower.mimic->driver);
  coupling.ratio = follower.mimic->multiplier;
  if (coupling.driver < 0) {
    fail("which is not between '" + urdf.ends.base_link + "' and '" + urdf.ends.tip_link + "'");
  }
  if (coupling.driver == coupling.joint) fail("which is the joint itself");
  if (chain.joints[coupling.joint].type != chain.joints[coupling.driver].type) {
    fail("and one of them turns while the other slides");
  }
  for (const UrdfJoint& joint : urdf.joints) {
    if (joint.name == follower.mimic->driver && joint.mimic) fail("which mimics '" + joint.mimic->driver + "'");
  }
  return coupling;
}

}  // namespace

std::optional<SignedAxis> ElementaryAxis(const Vector3<double>& unit) {
  for (int i = 0; i < 3; ++i) {
    Vector3<double> rest = unit;
    rest[i] = 0.0;
    if (rest.norm() < 1e-12) return SignedAxis{static_cast<Axis>(i), unit[i] < 0.0 ? -1.0 : 1.0};
  }
  return std::nullopt;
}

Robot RobotFromUrdf(const UrdfChain& urdf, const std::string& file_in_messages) {
  ChainBuilder builder;
  for (const UrdfJoint& joint : urdf.joints) builder.Append(joint);
  Robot robot;
  robot.name = urdf.robot_name;
  robot.chain = std::move(builder).chain();
  for (const UrdfJoint& joint : urdf.joints) {
    if (joint.mimic && !joint.is_fixed()) {
      robot.chain.couplings.push_back(CouplingOf(urdf, joint, robot.chain, file_in_messages));
    }
  }
  return robot;
}

Robot ReadUrdfText(const std::string& text, const std::string& file_in_messages, const UrdfEnds& ends) {
  return RobotFromUrdf(ReadUrdfChain(text, file_in_messages, ends), file_in_messages);
}

Robot ReadUrdfFile(const std::string& path, const UrdfEnds& ends) {
  return ReadUrdfText(ReadTextFile(path), path, ends);
}

bool IsUrdf(const std::string& path, const std::string& text) {
  const std::string ending = ".urdf";
  if (path.size() > ending.size() && path.compare(path.size() - ending.size(), ending.size(), ending) == 0) return true;
  size_t first = text.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0;
  first = text.find_first_not_of(" \t\r\n", first);
  return first != std::string::npos && text[first] == '<';
}

}  // namespace sagitta
