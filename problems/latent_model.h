// Repeatability as latent joint deviations: at every visit (one arrival at a
// configuration) each joint is off by its own N(0, sigma_j^2), on the encoder
// side. All markers, loads and repeats of the visit share it.
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"
#include "problems/experiment.h"
#include "problems/measurements.h"

namespace sagitta {

struct LatentModel {
  std::vector<int> joints;         // those that deviate
  Eigen::VectorXd sigmas;          // rad or m, one per entry of `joints`
  std::vector<int> visit_of_shot;  // index of the visit, one per shot
  int num_visits = 0;
  // Found, and no pose was visited again: it may be an error that follows the pose, which predictions have, too.
  bool may_follow_pose = false;

  bool empty() const { return joints.empty(); }
  int size() const { return static_cast<int>(joints.size()); }
};

// Throws InputError for a joint the robot does not have.
LatentModel MakeLatentModel(const Chain& chain, const Measurements& data, const Experiment& experiment);

// The visits of other rows: joints and their deviations stay as they were stated or found.
void RenewVisits(const Measurements& data, LatentModel* latent);

}  // namespace sagitta
