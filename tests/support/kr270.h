// The KUKA KR 270 as papers 000 and 002 describe it, written by hand so that the
// robot-file reader is not needed to test the models.
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"
#include "tests/support/arms.h"

namespace sagitta::test {

// The 18 errors in the order of paper 002, Table III.
inline const std::vector<std::string>& Kr270Errors() {
  static const std::vector<std::string> names = {"p_x1",   "p_y1", "phi_x1", "dq2",  "p_x2",   "phi_x2",
                                                 "phi_z2", "dq3",  "p_x3",   "p_z3", "phi_z3", "dq4",
                                                 "p_y4",   "p_z4", "phi_z4", "dq5",  "p_z5",   "phi_z5"};
  return names;
}

inline Chain Kr270Chain() {
  constexpr Motion kTurns = Motion::kRotation;
  Chain chain;
  chain.joints = Revolutes(6, "A");
  chain.transforms = {
      Translate(Axis::kZ, 0.750),          OnJoint(kTurns, Axis::kZ, 0),        Translate(Axis::kX, 0.350, "p_x1"),
      Translate(Axis::kY, 0, "p_y1"),      Rotate(Axis::kX, 0, "phi_x1"),       OnJoint(kTurns, Axis::kY, 1, "dq2"),
      Translate(Axis::kX, 1.250, "p_x2"),  Rotate(Axis::kX, 0, "phi_x2"),       Rotate(Axis::kZ, 0, "phi_z2"),
      OnJoint(kTurns, Axis::kY, 2, "dq3"), Translate(Axis::kX, 1.100, "p_x3"),  Translate(Axis::kZ, -0.055, "p_z3"),
      Rotate(Axis::kZ, 0, "phi_z3"),       OnJoint(kTurns, Axis::kX, 3, "dq4"), Translate(Axis::kY, 0, "p_y4"),
      Translate(Axis::kZ, 0, "p_z4"),      Rotate(Axis::kZ, 0, "phi_z4"),       OnJoint(kTurns, Axis::kY, 4, "dq5"),
      Translate(Axis::kZ, 0, "p_z5"),      Rotate(Axis::kZ, 0, "phi_z5"),       OnJoint(kTurns, Axis::kX, 5),
      Translate(Axis::kX, 0.230),
  };
  return chain;
}

}  // namespace sagitta::test
