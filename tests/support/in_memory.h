// An arm and readings of it that were never in a file, as a program that links the library makes them
// (tests/consumer/diagnose_in_memory.cc).
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "models/forward_model.h"
#include "problems/experiment.h"
#include "problems/io/robot_file.h"
#include "problems/measurements.h"
#include "problems/simulation.h"

namespace sagitta::test {

inline Robot ArmInMemory() {
  return ReadRobotText(R"(
schema: sagitta/robot/1
name: six axes
joints: [{name: A1, type: revolute}, {name: A2, type: revolute}, {name: A3, type: revolute},
         {name: A4, type: revolute}, {name: A5, type: revolute}, {name: A6, type: revolute}]
kinematics:
  dh:
    convention: standard
    links:
      - {joint: A1, a_mm: 150, alpha_deg: -90, d_mm: 400, theta_deg: 0}
      - {joint: A2, a_mm: 600, alpha_deg: 0, d_mm: 0, theta_deg: -90}
      - {joint: A3, a_mm: 120, alpha_deg: -90, d_mm: 0, theta_deg: 0}
      - {joint: A4, a_mm: 0, alpha_deg: 90, d_mm: 640, theta_deg: 0}
      - {joint: A5, a_mm: 0, alpha_deg: -90, d_mm: 0, theta_deg: 0}
      - {joint: A6, a_mm: 0, alpha_deg: 0, d_mm: 80, theta_deg: 0}
)",
                       "arm in memory");
}

constexpr double kSigmaInMemory = 2e-5;  // m

// Configurations c0, c1 ... from station S1, each with the markers M1, M2, M3.
inline Measurements ReadingsInMemory(const Robot& robot, int configurations = 30) {
  const Vector3<double> points[] = {{0.05, 0.0, 0.1}, {-0.03, 0.06, 0.12}, {0.0, -0.05, 0.15}};
  const ForwardModel model(robot.chain);
  const std::vector<double> no_errors(model.num_parameters(), 0.0);
  NormalNumbers normal(11);
  Measurements data;
  data.stations = {"S1"};
  data.markers = {"M1", "M2", "M3"};
  for (int c = 0; c < configurations; ++c) {
    Configuration configuration;
    configuration.id = "c" + std::to_string(c);
    configuration.q = Eigen::VectorXd(6);
    for (double& angle : configuration.q) angle = std::clamp(0.7 * normal(), -1.5, 1.5);
    Shot shot;
    shot.configuration = c;
    shot.station = 0;
    for (int m = 0; m < 3; ++m) {
      Observation row;
      row.shot = c;
      row.marker = m;
      row.point_in_station =
          model.PointInBase(ShotInput(configuration.q), no_errors.data(), robot.chain.FlangeFrame(), points[m]);
      for (double& coordinate : row.point_in_station) coordinate += kSigmaInMemory * normal();
      row.sigma.setConstant(kSigmaInMemory);
      shot.observations.push_back(static_cast<int>(data.observations.size()));
      data.observations.push_back(row);
    }
    data.configurations.push_back(configuration);
    data.shots.push_back(shot);
  }
  return data;
}

}  // namespace sagitta::test
