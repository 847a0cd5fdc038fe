// The robots of the cases: nominal arm, what is believed to be free, and sizes.
#pragma once

#include <string>
#include <vector>

#include "tests/hidden_effects/generator/nature.h"

namespace hidden {

struct LoadState {
  std::string name;
  double mass = 0.0;  // kg; 0: a sideways pull
  double pull = 0.0;  // N
};

struct RobotKind {
  Arm arm;
  std::vector<std::string> free_errors;  // complete and minimal together with base and markers
  VectorXd compliance;                   // rad/(N m), typical; 0: rigid
  Vector3d load_point;                   // m, flange frame
  LoadState heavy, light, sideways;
  double marker_spread = 0.1;  // m
  bool has_spring = false;     // believed
  Spring spring;
};

// kr270, kr270_compensator, ur10, seven, track. Throws for another.
RobotKind MakeRobot(const std::string& name);

}  // namespace hidden
