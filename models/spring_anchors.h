// Where the compensator's spring is fixed, from the points of its two ends: the lever end P1, on the frame right
// after the joint, and the anchor P2, on a frame before it.
//
// At joint value 0 (errors and deflections of the joint are part of its value), with the axis w through o, all in
// the frame that P2 rides on, and p_perp = p - o - (w . (p - o)) w:
//
//   L = |P1_perp|,  u = P1_perp / L,  v = w x u,  a_x = -v . (P2 - o),  a_y = -u . (P2 - o)
//
// the sense of s^2 = a^2 + L^2 + 2 a L cos(alpha - q), alpha = atan2(a_x, a_y) (gravity_compensator.h).
#pragma once

#include <vector>

#include "models/kinematics.h"

namespace sagitta {

struct SpringAnchors {
  Chain between;             // the transforms from P2's frame to the joint, without joints
  ElementaryTransform axis;  // the joint's own
};

// (L, a_x, a_y), m. `values`: of the transforms between, rad or m.
template <typename T>
Vector3<T> SpringGeometry(const SpringAnchors& anchors, const T* values, const Vector3<T>& lever,
                          const Vector3<T>& anchor) {
  ChainState<T> state;
  EvaluateChain(anchors.between, values, &state);
  Pose<T> before = state.frames.back();
  const Vector3<T> axis = T(anchors.axis.sign) * before.rotation.col(static_cast<int>(anchors.axis.axis));
  RotateInPlace(anchors.axis.axis, T(anchors.axis.nominal), &before.rotation);
  const Vector3<T> arm = before.rotation * lever;  // P1 - o
  const Vector3<T> radial = arm - axis.dot(arm) * axis;
  const T length = radial.norm();
  const Vector3<T> u = radial / length;
  const Vector3<T> to_anchor = anchor - before.translation;
  return {length, -axis.cross(u).dot(to_anchor), -u.dot(to_anchor)};
}

}  // namespace sagitta
