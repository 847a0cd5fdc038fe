// What is measured: configurations, loads, stations, times, approach directions.
#pragma once

#include <string>
#include <vector>

#include "tests/hidden_effects/generator/random_streams.h"
#include "tests/hidden_effects/generator/robots.h"

namespace hidden {

struct DesignOptions {
  int configurations = 60;
  int stations = 1;
  bool loaded = true;
  bool time = true, temperature = true, approach = true;  // columns that the file has
};

struct Design {
  DesignOptions options;
  std::vector<Shot> shots;
  // Way of the arm: where every joint turned before it arrived, and where it arrived.
  std::vector<VectorXd> turning_points, arrivals;  // per configuration
};

Design MakeDesign(const RobotKind& robot, const DesignOptions& options, Stream* random);

}  // namespace hidden
