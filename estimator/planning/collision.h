// Does a body of the arm meet another one, a box of the cell, or a line of sight: FCL (Pan, Chitta, Manocha, FCL: A
// general purpose library for collision and proximity queries, ICRA 2012) on capsules and boxes.
//
// Bodies are numbered by the joint that moves them, 0 the foot; those that share a joint may touch, and so may pairs
// that the cell names. What stands on the foot is not compared with boxes and floor: it does not move.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "models/chain.h"
#include "problems/cell.h"

namespace sagitta {

class CollisionScene {
 public:
  CollisionScene(const Chain& chain, const Cell& cell);
  ~CollisionScene();

  // frames: base_from_frame of the chain (ChainState::frames). Empty, or what meets what, in words.
  std::string Collision(const std::vector<Pose<double>>& frames) const;
  // What stands between two points of the base frame, m; empty: nothing.
  std::string Obstruction(const std::vector<Pose<double>>& frames, const Vector3<double>& instrument,
                          const Vector3<double>& reflector) const;

 private:
  struct Shapes;
  std::unique_ptr<Shapes> shapes_;
};

}  // namespace sagitta
