// Deviations of every joint as columns: what a joint's own error does to the points.
#pragma once

#include <numeric>

#include "problems/latent_model.h"

namespace sagitta {

// The same visits with a deviation of every joint, of one unit (rad or m).
inline LatentModel WithAllJoints(LatentModel latent, int num_joints) {
  latent.joints.resize(static_cast<size_t>(num_joints));
  std::iota(latent.joints.begin(), latent.joints.end(), 0);
  latent.sigmas = Eigen::VectorXd::Ones(num_joints);
  return latent;
}

}  // namespace sagitta
