#include "models/wrench.h"

namespace sagitta {

double GeneralisedForceDerivative(const Chain& chain, const ChainState<double>& state, int b, int a,
                                  const WrenchInBase<double>& wrench, bool turns_with_arm) {
  if (a >= wrench.frame || b >= wrench.frame) return 0.0;
  const bool a_turns = chain.transforms[a].is_rotation();
  const bool b_turns = chain.transforms[b].is_rotation();
  const Vector3<double>& z_a = state.axis[a];
  const Vector3<double>& z_b = state.axis[b];
  const Vector3<double> r = wrench.point - state.origin[b];
  Vector3<double> d_z = Vector3<double>::Zero();
  Vector3<double> d_r = Vector3<double>::Zero();
  if (a < b) {
    if (a_turns) d_z = z_a.cross(z_b);
    if (a_turns) d_r = z_a.cross(r);
  } else {
    d_r = a_turns ? Vector3<double>(z_a.cross(wrench.point - state.origin[a])) : z_a;
  }
  Vector3<double> d_force = Vector3<double>::Zero();
  Vector3<double> d_moment = Vector3<double>::Zero();
  if (turns_with_arm && a_turns) {
    d_force = z_a.cross(wrench.force);
    d_moment = z_a.cross(wrench.moment);
  }
  if (!b_turns) return d_z.dot(wrench.force) + z_b.dot(d_force);
  const Vector3<double> torque = r.cross(wrench.force) + wrench.moment;
  return d_z.dot(torque) + z_b.dot(d_r.cross(wrench.force) + r.cross(d_force) + d_moment);
}

}  // namespace sagitta
