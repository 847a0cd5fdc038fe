// Effects whose parameters each move one thing, by a function of the shot: a joint deviates on the encoder's side
// (encoder errors, waves, play, slips), or a marker moves along an axis of its frame. What they do to a point is what a
// unit of that motion does, times the function.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "models/forward_model.h"

namespace sagitta {

struct SingleMotion {
  enum class Of { kNothing, kJoint, kMarker };
  Of of = Of::kNothing;
  int owner = -1;            // the joint, in its positive direction, or the marker
  int axis = 0;              // of a marker
  Eigen::VectorXd per_unit;  // of each shot: rad or m per SI unit of the parameter
};

// One for each parameter of the effect; null where any does anything else, or nothing in all shots. markers: names.
std::optional<std::vector<SingleMotion>> SingleMotionsOf(const Robot& robot, const std::vector<std::string>& markers,
                                                         const EffectSpec& spec, const std::vector<ShotInput>& shots);

}  // namespace sagitta
