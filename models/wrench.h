// Wrenches on the arm and the joint torques they cause.
//
// A force F (N) and a moment M (N m) act at a point x that rides on a frame of
// the chain. The generalised force on transform e before that frame is
//
//   tau_e = z_e . ((x - o_e) x F + M)   rotation, N m
//   tau_e = z_e . F                     translation, N
//
// (tau = (dFK/d delta)' w, paper 000 eq. (2)), everything in the base frame.
#pragma once

#include <vector>

#include "models/chain.h"
#include "models/kinematics.h"

namespace sagitta {

// The frame a wrench's components are given in. A wrench given in the
// measurement frame turns against the base when the base rotation changes; one
// given in the flange turns with the flange.
enum class WrenchFrame { kMeasurement, kBase, kFlange };

struct AppliedWrench {
  int frame = 0;                                     // chain frame its point rides on
  Vector3<double> point = Vector3<double>::Zero();   // m, in that frame
  Vector3<double> force = Vector3<double>::Zero();   // N
  Vector3<double> moment = Vector3<double>::Zero();  // N m, about the point
  WrenchFrame expressed_in = WrenchFrame::kMeasurement;
};

// The same in the base frame at one state of the chain.
template <typename T>
struct WrenchInBase {
  int frame = 0;
  Vector3<T> point, force, moment;
};

template <typename T>
WrenchInBase<T> ToBase(const AppliedWrench& wrench, const ChainState<T>& state, const Matrix3<T>& base_rotation) {
  WrenchInBase<T> result;
  result.frame = wrench.frame;
  result.point = state.frames[wrench.frame] * Vector3<T>(wrench.point.cast<T>());
  Matrix3<T> base_from_given = Matrix3<T>::Identity();
  if (wrench.expressed_in == WrenchFrame::kMeasurement) base_from_given = base_rotation.transpose();
  if (wrench.expressed_in == WrenchFrame::kFlange) base_from_given = state.frames[wrench.frame].rotation;
  result.force = base_from_given * wrench.force.cast<T>();
  result.moment = base_from_given * wrench.moment.cast<T>();
  return result;
}

// tau_e of one wrench; 0 for a transform beyond the wrench's frame.
template <typename T>
T GeneralisedForce(const Chain& chain, const ChainState<T>& state, int e, const WrenchInBase<T>& wrench) {
  if (e >= wrench.frame) return T(0);
  if (!chain.transforms[e].is_rotation()) return state.axis[e].dot(wrench.force);
  const Vector3<T> arm = wrench.point - state.origin[e];
  return state.axis[e].dot(Vector3<T>(arm.cross(wrench.force) + wrench.moment));
}

// d tau_b / d v_a: the second-order term. `turns_with_arm`: the wrench is given
// in the flange. With a rotation a:
//   a < b   z_b, x - o_b turn with a:   (z_a x z_b) . (r x F + M) + z_b . ((z_a x r) x F)
//   a >= b  only x moves:               z_b . ((z_a x (x - o_a)) x F)
double GeneralisedForceDerivative(const Chain& chain, const ChainState<double>& state, int b, int a,
                                  const WrenchInBase<double>& wrench, bool turns_with_arm);

}  // namespace sagitta
