// An arm as it really moves: elementary transforms from base to flange, small
// tilts right after each joint and at the foot. Shares nothing with models/.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace hidden {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

enum class Move { kTx, kTy, kTz, kRx, kRy, kRz };

inline bool IsTurn(Move move) { return move >= Move::kRx; }
inline int AxisNumber(Move move) { return static_cast<int>(move) % 3; }

struct Element {
  Move move;
  double nominal = 0.0;  // m or rad
  int joint = -1;
  std::string error;        // name of its geometric error; "" : none
  double deviation = 0.0;   // true minus nominal
  int dh_link = -1;         // of a DH table
  std::string dh_quantity;  // theta, d, a, alpha, beta
};

struct JointLimits {
  std::string name;
  bool prismatic = false;
  double low = 0.0, high = 0.0;  // rad or m
};

struct Arm {
  std::string name;
  bool is_dh = false;
  std::vector<JointLimits> joints;
  std::vector<Element> elements;

  int size() const { return static_cast<int>(joints.size()); }
  int Find(const std::string& joint) const;
  const Element& ElementOf(int joint) const;
  int AxisOf(int joint) const { return AxisNumber(ElementOf(joint).move); }
};

// What moves: actual joint values, tilts (about x, y, z of the frame after the
// joint), tilt of the foot, links that bend about their middle (by joint before
// the link, in the frame after it) and that lengthen (link 0: before the first joint).
struct Posture {
  explicit Posture(int joints)
      : values(VectorXd::Zero(joints)),
        tilt(joints, Vector3d::Zero()),
        foot(Vector3d::Zero()),
        bend(joints, Vector3d::Zero()),
        lengthening(VectorXd::Zero(joints + 1)) {}
  VectorXd values;
  std::vector<Vector3d> tilt;
  Vector3d foot;
  std::vector<Vector3d> bend;  // rad
  VectorXd lengthening;        // part of the length
};

struct Frame {
  Matrix3d turn = Matrix3d::Identity();
  Vector3d origin = Vector3d::Zero();
  Vector3d Map(const Vector3d& point) const { return origin + turn * point; }
};

// In the base frame (as it stands on the ground, before the foot tilts).
struct Placement {
  std::vector<Frame> after_joint;
  std::vector<Vector3d> axis;  // of each joint
  Frame flange;
};

Placement Place(const Arm& arm, const Posture& posture);

Matrix3d SmallTurn(const Vector3d& turn);

}  // namespace hidden
