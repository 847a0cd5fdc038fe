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

// The load id of rows that hang nothing on the arm.
constexpr char kNoLoad[] = "none";

// Force and moment at a point that rides on the arm.
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

// base_rotation: R of base_in_station, for wrenches given in the measurement frame.
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

// tau_e of all of them.
template <typename T>
T GeneralisedForce(const Chain& chain, const ChainState<T>& state, int e, const std::vector<AppliedWrench>& wrenches,
                   const Matrix3<T>& base_rotation) {
  T force(0);
  for (const AppliedWrench& wrench : wrenches) {
    force += GeneralisedForce(chain, state, e, ToBase(wrench, state, base_rotation));
  }
  return force;
}

// The generalised force on one transform b by many wrenches, and its derivative by every transform a: the second-order
// term. All terms are linear in z_a, so that the wrenches are summed before any a is looked at. r = x - o_b,
// t = r x F + M, and with b a rotation:
//
//   rotation a < b     z_b and r turn with a     z_a . (z_b x t + (z_b . r) F - (r . F) z_b)
//   rotation a >= b    only x moves              z_a . (x x h - o_a x h)                      h = F x z_b
//   translation a >= b                           z_a . h
//
// With b a translation: z_a . (z_b x F), 0, 0. A wrench given in the flange turns with every rotation a before it:
// z_a . ((r . F) z_b - (F . z_b) r + M x z_b) more, or z_a . h.
class ForceOnTransform {
 public:
  ForceOnTransform(const Chain& chain, const ChainState<double>& state, int b);

  double force() const { return force_; }
  void AddForce(const WrenchInBase<double>& wrench, double times);
  void AddDerivative(const WrenchInBase<double>& wrench, bool turns_with_arm, double times);
  Eigen::RowVectorXd ByValues() const;  // d force / d v_a, 1 x transforms

 private:
  const Chain& chain_;
  const ChainState<double>& state_;
  const int b_;
  double force_ = 0.0;
  Vector3<double> before_ = Vector3<double>::Zero();  // by rotations before b
  Eigen::MatrixXd by_frame_;  // 6 x frames; by transforms from b on and before the frame: sum of x x h, sum of h
};

}  // namespace sagitta
