// A KR-270 whose flange points the same way in every configuration, as real grids
// do: the wrist undoes what the arm turns. Tool point and base position are then
// one sum. Generator as in kr270_experiment.h, not from models/.
#pragma once

#include "tests/support/kr270_experiment.h"

namespace sagitta::test {

// Joint values with the (nominal) flange orientation `target`, arm joints drawn.
inline Eigen::VectorXd PointingAt(const Eigen::Matrix3d& target, RandomNumbers* random) {
  Eigen::VectorXd q(6);
  q[0] = random->Uniform(-50, 50) * kDegree;
  q[1] = random->Uniform(-110, -40) * kDegree;
  q[2] = random->Uniform(20, 110) * kDegree;
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  const Eigen::Matrix3d wrist = (Turn(z, q[0]) * Turn(y, q[1]) * Turn(y, q[2])).transpose() * target;
  const Eigen::Vector3d angles = wrist.eulerAngles(0, 1, 0);
  q.tail<3>() = angles;
  return q;
}

// One station, one marker, `poses` configurations that all point at `target`.
inline Measurements ConstantOrientationGrid(const Eigen::Matrix3d& target, int poses, std::uint64_t seed,
                                            double sigma) {
  RandomNumbers random(seed);
  Measurements data;
  data.files.resize(1);
  data.files[0].path = "grid.csv";
  data.stations = {"S1"};
  data.markers = {"P1"};
  for (int c = 0; c < poses; ++c) {
    Configuration configuration;
    configuration.id = "G" + std::to_string(c);
    configuration.q = PointingAt(target, &random);
    data.configurations.push_back(configuration);
    Shot shot;
    shot.configuration = c;
    shot.station = 0;
    shot.observations = {c};
    data.shots.push_back(shot);
    Observation observation;
    observation.shot = c;
    observation.marker = 0;
    observation.sigma.setConstant(sigma);
    observation.file = 0;
    observation.row = c;
    data.files[0].rows.push_back({c + 2, {}});
    data.observations.push_back(observation);
  }
  return data;
}

}  // namespace sagitta::test
