// Which way the controller's flange faces, by what a user states of it.
#pragma once

#include "models/chain.h"
#include "models/geometry.h"

namespace sagitta {

// Whether the z axis of a flange runs back into the arm, along the last axis: from where that axis is nearest to the
// one before it towards the flange is out. Controllers' flanges face away (ISO 9787, mechanical interface: +Z_m points
// away from it). controller_flange: in that of the chain. False where the last two axes are parallel, the last one
// slides, or the flange lies where they are nearest.
bool FacesTheArm(const Chain& chain, const Pose<double>& controller_flange);

}  // namespace sagitta
