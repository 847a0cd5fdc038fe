// Arms of a DH table and what a tracker reads of them: kinematics written out as 4x4 matrices, not from models/, so
// that what is judged does not judge itself.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "problems/calibration_problem.h"
#include "tests/support/arms.h"

namespace sagitta::test {

inline std::vector<DhRow> Ur10Rows() {
  return {{0, 90, 0.1273, 0},   {-0.612, 0, 0, 0},   {-0.5723, 0, 0, 0},
          {0, 90, 0.163941, 0}, {0, -90, 0.1157, 0}, {0, 0, 0.0922, 0}};
}

// Rz(theta + q) Tz(d) Tx(a) Rx(alpha), written out (Denavit and Hartenberg 1955).
inline Eigen::Matrix4d Link(const DhRow& row, double q) {
  const double t = row.theta_deg * kDegree + q, al = row.alpha_deg * kDegree;
  Eigen::Matrix4d link;
  link << std::cos(t), -std::sin(t) * std::cos(al), std::sin(t) * std::sin(al), row.a * std::cos(t),  //
      std::sin(t), std::cos(t) * std::cos(al), -std::cos(t) * std::sin(al), row.a * std::sin(t),      //
      0, std::sin(al), std::cos(al), row.d, 0, 0, 0, 1;
  return link;
}

// One marker at configurations of the arm `rows`.
inline Measurements Measure(const std::vector<DhRow>& rows, std::uint64_t seed, int configurations = 30) {
  RandomNumbers random(seed);
  Measurements data;
  data.files.resize(1);
  data.files[0].path = "arm.csv";
  data.stations = {"S1"};
  data.markers = {"P1"};
  for (int c = 0; c < configurations; ++c) {
    Eigen::VectorXd q(rows.size());
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    for (size_t j = 0; j < rows.size(); ++j) {
      q[j] = random.Uniform(-120, 120) * kDegree;
      pose = pose * Link(rows[j], q[j]);
    }
    data.configurations.push_back({"C" + std::to_string(c), q, false});
    Shot shot;
    shot.configuration = c;
    shot.station = 0;
    shot.observations = {c};
    data.shots.push_back(shot);
    Observation observation;
    observation.shot = c;
    observation.marker = 0;
    observation.file = 0;
    observation.row = c;
    observation.point_in_station = (pose * Eigen::Vector4d(0.03, -0.02, 0.06, 1)).head<3>();
    for (int axis = 0; axis < 3; ++axis) observation.point_in_station[axis] += random.Uniform(-1e-4, 1e-4);
    data.files[0].rows.push_back({c + 2, {}});
    data.observations.push_back(observation);
  }
  return data;
}

inline CalibrationProblem ProblemOf(const std::vector<DhRow>& rows, Measurements data,
                                    DhConvention convention = DhConvention::kStandard) {
  Robot robot;
  DhTable table;
  table.convention = convention;
  for (size_t j = 0; j < rows.size(); ++j) {
    const DhRow& row = rows[j];
    table.links.push_back({static_cast<int>(j), row.a, row.alpha_deg * kDegree, row.d, row.theta_deg * kDegree, 0.0});
  }
  robot.chain = ChainFromDhTable(Revolutes(static_cast<int>(rows.size())), {}, table);
  robot.dh = table;
  return MakeCalibrationProblem(robot, std::move(data), Experiment());
}

// A real arm whose errors reach 5 mm and 1 deg, each; every third has all of them that large.
inline std::vector<DhRow> WithLargeErrors(const std::vector<DhRow>& nominal, int seed) {
  RandomNumbers random(1000 + seed);
  const bool extreme = seed % 3 == 0;
  const auto error = [&](double most) {
    const double drawn = random.Uniform(-most, most);
    return extreme ? std::copysign(most, drawn) : drawn;
  };
  std::vector<DhRow> real = nominal;
  for (DhRow& row : real) {
    row.a += error(5e-3);
    row.d += error(5e-3);
    row.alpha_deg += error(1);
    row.theta_deg += error(1);
  }
  return real;
}

// The nominal arm and 30 configurations of a real one; of every fourth one row is half a metre off.
inline CalibrationProblem ArmWithLargeErrors(int seed) {
  const std::vector<std::vector<DhRow>> arms = {Ur5Rows(), Ur10Rows(), PumaStandardRows(), IiwaRows()};
  const std::vector<DhRow>& nominal = arms[seed % arms.size()];
  Measurements data = Measure(WithLargeErrors(nominal, seed), seed);
  if (seed % 4 == 1) data.observations[7].point_in_station.x() += 0.5;
  return ProblemOf(nominal, data);
}

}  // namespace sagitta::test
