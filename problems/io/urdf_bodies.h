// The bodies of an arm as its URDF describes them for collisions: spheres, cylinders and boxes, each as the smallest
// capsule around its longest axis. Meshes are not read; who carries one is listed.
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"
#include "problems/cell.h"
#include "problems/io/urdf_chain.h"

namespace sagitta {

struct UrdfBodies {
  std::vector<LinkCapsule> capsules;  // named after their links; several of one link: with a number behind
  std::vector<std::string> meshes;    // links with a collision geometry that is not read
  std::vector<std::string> moving;    // links outside the chain that move on their own
  std::vector<std::string> bare;      // links of the chain that have no collision geometry
};

// chain: the robot's own, which may be written in other frames (DH) and be calibrated. Throws InputError where its
// joints are others than those of the URDF, or its axes lie more than 20 mm or 20 mrad elsewhere.
UrdfBodies BodiesFromUrdf(const UrdfChain& urdf, const Chain& chain, const std::string& file_in_messages);

}  // namespace sagitta
