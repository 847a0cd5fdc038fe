// Forward kinematics of a chain and the one derivative rule behind every column.
//
// Let transform e act about (rotation) or along (translation) the axis z_e
// through the origin o_e, both in the base frame. A point p beyond e moves by
//
//   dp / dv_e = z_e x (p - o_e)   rotation
//   dp / dv_e = z_e               translation
//
// and a point before e does not move. Source: Hollerbach, Khalil, Gautier,
// Springer Handbook of Robotics, chapter "Model identification"; derived in
// docs/DECISIONS.md.
#pragma once

#include <vector>

#include "models/chain.h"
#include "models/geometry.h"

namespace sagitta {

// rotation <- rotation * R_axis(angle), touching two columns only.
template <typename T>
void RotateInPlace(Axis axis, const T& angle, Matrix3<T>* rotation) {
  using std::cos;
  using std::sin;
  const T c = cos(angle);
  const T s = sin(angle);
  const int i = (static_cast<int>(axis) + 1) % 3;
  const int k = (static_cast<int>(axis) + 2) % 3;
  const Vector3<T> u = rotation->col(i);
  const Vector3<T> v = rotation->col(k);
  rotation->col(i) = c * u + s * v;
  rotation->col(k) = c * v - s * u;
}

// The state of a chain at given transform values; all in the base frame, SI.
template <typename T>
struct ChainState {
  std::vector<Vector3<T>> axis;    // z_e, one per transform
  std::vector<Vector3<T>> origin;  // o_e, one per transform
  std::vector<Pose<T>> frames;     // base_from_frame f, f = 0 .. num_transforms
};

// values: v_e, one per transform.
template <typename T>
void EvaluateChain(const Chain& chain, const T* values, ChainState<T>* state) {
  const int n = chain.num_transforms();
  state->axis.resize(n);
  state->origin.resize(n);
  state->frames.resize(n + 1);
  Pose<T> base_from_here;
  state->frames[0] = base_from_here;
  for (int e = 0; e < n; ++e) {
    const ElementaryTransform& transform = chain.transforms[e];
    state->axis[e] = base_from_here.rotation.col(static_cast<int>(transform.axis));
    state->origin[e] = base_from_here.translation;
    if (transform.is_rotation()) {
      RotateInPlace(transform.axis, values[e], &base_from_here.rotation);
    } else {
      base_from_here.translation += state->axis[e] * values[e];
    }
    state->frames[e + 1] = base_from_here;
  }
}

// Compiled once (kinematics.cc).
extern template void EvaluateChain(const Chain& chain, const double* values, ChainState<double>* state);

// base_from_frame of every frame f of the nominal chain at joint values q (SI): num_transforms() + 1 poses.
std::vector<Pose<double>> NominalFrames(const Chain& chain, const Eigen::VectorXd& q);

// dp / dv_e of a point beyond transform e.
template <typename T>
Vector3<T> PointVelocity(const Chain& chain, const ChainState<T>& state, int e, const Vector3<T>& point_in_base) {
  if (!chain.transforms[e].is_rotation()) return state.axis[e];
  return state.axis[e].cross(Vector3<T>(point_in_base - state.origin[e]));
}

}  // namespace sagitta
