// The KR 270's poses with a measured torque on every joint: +-800 N m, as a loaded arm of its size shows.
#pragma once

#include "tests/support/kr270_experiment.h"
#include "tests/support/random_numbers.h"

namespace sagitta::test {

inline Measurements DesignWithTorques() {
  Kr270Design design;
  design.configurations = 40;
  Measurements data = DesignMeasurements(design);
  RandomNumbers random(4);
  for (Shot& shot : data.shots) {
    shot.joint_torques.resize(6);
    for (double& torque : shot.joint_torques) torque = random.Uniform(-800.0, 800.0);
  }
  return data;
}

}  // namespace sagitta::test
