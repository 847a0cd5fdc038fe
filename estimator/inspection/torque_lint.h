// Measured joint torques (columns tau<i>) against those that the model expects of its loads, joint by joint.
//
// A line measured = offset + slope * modelled by least squares. A slope near 1 and a high correlation: the two agree. A
// slope near -1: the file gives what the drives deliver, not what the loads ask for. What is left other than the line
// is what the model lacks (link weights) or what the sensor adds (friction, offsets).
#pragma once

#include <string>
#include <vector>

#include "problems/calibration_problem.h"

namespace sagitta {

// One joint.
struct JointTorqueComparison {
  int joint = -1;
  int shots = 0;
  double measured_rms = 0.0, modelled_rms = 0.0, difference_rms = 0.0;  // N m, or N
  double slope = 0.0, offset = 0.0;                                     // of measured over modelled; N m, or N
  double slope_sigma = 0.0;                                             // of the scatter about the line
  double correlation = 0.0;                                             // 0 where one of the two does not vary
  bool varies = false;                                                  // what the model expects
};

// All joints of rows that state torques.
struct TorqueComparison {
  std::vector<JointTorqueComparison> joints;  // empty: no row states torques
  bool measured_count = false;                // `torques: measured`
  std::string words;
};

// One joint's torque where both agree but for a factor.
struct ScaledTorque {
  int joint = -1;
  double slope = 1.0;
};
// Of joints whose factor is no error of a torque sensor, beyond its own uncertainty at `significance` over all joints;
// the farthest from 1 first. There the model lacks weights that bend the arm, or has wrong ones.
std::vector<ScaledTorque> TorquesOffByAFactor(const TorqueComparison& comparison, double significance);

// At the model's parameters; calibration and validation rows alike.
TorqueComparison CompareTorques(const CalibrationProblem& problem, const ParameterSet& parameters);

}  // namespace sagitta
