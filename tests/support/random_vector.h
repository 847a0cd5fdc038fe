// A vector of three draws, in an order that no compiler chooses: that of arguments is open, and with it the sample.
#pragma once

#include "models/geometry.h"

namespace sagitta {
namespace test {

template <typename Draw>
Vector3<double> RandomVector(Draw&& draw) {
  const double z = draw();
  const double y = draw();
  const double x = draw();
  return {x, y, z};
}

}  // namespace test
}  // namespace sagitta
