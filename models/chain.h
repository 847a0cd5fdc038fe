// A robot arm as a flat list of elementary transforms, base to flange.
//
// Standard DH, modified DH, Hayati and URDF are only ways to write such a list
// (denavit_hartenberg.h). Every transform carries a nominal value and may carry
// a joint, a named error parameter, or both. The value of transform e is
//
//   v_e = nominal_e + sign_e * (q_j + coupling + encoder-side effects + latent_j) + delta_e
//
// where delta_e collects geometric errors and elastic deflections. Hence the
// kinematics, every geometric error, every joint offset and every deflection
// share one derivative (kinematics.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/geometry.h"

namespace sagitta {

enum class JointType { kRevolute, kPrismatic };

// A joint as the robot file has it; its value drives one transform.
struct Joint {
  std::string name;
  JointType type = JointType::kRevolute;
  std::optional<double> min;  // rad or m
  std::optional<double> max;  // rad or m

  // Limits that are equal: it has this value only, as a joint that is locked, or that moves with another and not by
  // itself (URDF's <mimic>).
  bool IsHeld() const { return min && max && *min == *max; }
  // False: it is held, and not there.
  bool Allows(double value) const;
};

// In their order.
std::vector<std::string> JointNames(const std::vector<Joint>& joints);

// What an elementary transform does with respect to its axis.
enum class Motion { kTranslation, kRotation };

// One of Tx Ty Tz Rx Ry Rz: value = nominal + sign (joint value) + error, m or rad.
struct ElementaryTransform {
  Motion motion = Motion::kTranslation;
  Axis axis = Axis::kX;
  double nominal = 0.0;    // m or rad; on a joint: its offset
  int joint = -1;          // index into Chain::joints, -1: fixed
  double sign = 1.0;       // of the joint value
  std::string error;       // name of the geometric error parameter, "" if none
  bool tilt_slot = false;  // silent (0) place for a tilt; not part of the description

  bool has_joint() const { return joint >= 0; }
  bool is_rotation() const { return motion == Motion::kRotation; }
};

// Joint `joint` moves by ratio * q_driver on top of its own value
// (parallelograms, FANUC J2-J3).
struct Coupling {
  int joint = -1;
  int driver = -1;
  double ratio = 0.0;
};

// Transforms from the base to the flange, in their order.
struct Chain {
  // Compiled once (chain.cc), not in each file that holds one.
  Chain();
  Chain(const Chain&);
  Chain(Chain&&) noexcept;
  Chain& operator=(const Chain&);
  Chain& operator=(Chain&&) noexcept;
  ~Chain();

  std::vector<Joint> joints;
  std::vector<ElementaryTransform> transforms;
  std::vector<Coupling> couplings;

  int num_joints() const { return static_cast<int>(joints.size()); }
  int num_transforms() const { return static_cast<int>(transforms.size()); }
  // Joints that can move by themselves.
  int num_driven() const;

  // Index of the joint or transform so named, -1 if there is none.
  int FindJoint(const std::string& name) const;
  int FindError(const std::string& error) const;
  // Index of the transform that carries the joint.
  int JointTransform(int joint) const;

  // A frame is named by how many transforms lie before it: 0 is the base,
  // num_transforms() the flange.
  // The base lies after the foot's tilt slots, a joint's frame after its own.
  int WorldFrame() const { return 0; }
  int BaseFrame() const { return AfterTiltSlots(0); }
  int FlangeFrame() const { return num_transforms(); }
  int FrameAfterJoint(int joint) const { return AfterTiltSlots(JointTransform(joint) + 1); }
  int AfterTiltSlots(int frame) const;

  // Joint values after coupling; SI.
  Eigen::VectorXd CoupledJointValues(const Eigen::VectorXd& q) const;

  // Empty when the chain is well formed: every joint carried exactly once, by a
  // transform of its kind, base to tip; error names unique.
  std::string Defect() const;
};

}  // namespace sagitta
