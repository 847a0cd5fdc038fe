// A KR-270 measured by a generator of its own: kinematics from rotation
// matrices and lever arms (papers 000, 002), not from models/, so that what is
// estimated does not prove itself.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "problems/calibration_problem.h"
#include "problems/simulation.h"
#include "tests/support/kr270.h"
#include "tests/support/random_vector.h"

namespace sagitta::test {

struct Kr270Truth {
  // m and rad, order of Kr270Errors(); paper 002, Table III.
  std::array<double, 18> errors = {
      -0.353e-3,        0.426e-3,         0.015 * kDegree, -0.007 * kDegree, 0.458e-3,         0.022 * kDegree,
      -0.023 * kDegree, -0.023 * kDegree, -0.214e-3,       -0.508e-3,        -0.011 * kDegree, 0.001 * kDegree,
      -0.167e-3,        -0.018e-3,        0.025 * kDegree, -0.011 * kDegree, 0.016e-3,         -0.008 * kDegree};
  std::vector<Vector3<double>> base_xyz = {{-0.023e-3, 0.010e-3, 0.057e-3}, {-0.099e-3, -0.098e-3, -0.076e-3}};
  std::vector<Vector3<double>> base_rotvec = {{-0.004 * kDegree, 0.001 * kDegree, -0.017 * kDegree},
                                              {-0.009 * kDegree, 0.006 * kDegree, -0.013 * kDegree}};
  std::vector<Vector3<double>> tools = {
      {0.27723, -0.04653, -0.09387}, {0.27649, -0.04825, 0.09405}, {0.27844, 0.10373, -0.00217}};
};

inline Eigen::Matrix3d Turn(const Eigen::Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

// Tool point in the robot's base frame by accumulating lever arms tip to base.
inline Vector3<double> IndependentKr270Point(const Eigen::VectorXd& q, const std::array<double, 18>& e,
                                             const Vector3<double>& tool) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  Vector3<double> p = Turn(x, q[5]) * (tool + Vector3<double>(0.230, 0, 0));
  p = Turn(y, q[4] + e[15]) * (Vector3<double>(0, 0, e[16]) + Turn(z, e[17]) * p);
  p = Turn(x, q[3] + e[11]) * (Vector3<double>(0, e[12], e[13]) + Turn(z, e[14]) * p);
  p = Turn(y, q[2] + e[7]) * (Vector3<double>(1.100 + e[8], 0, -0.055 + e[9]) + Turn(z, e[10]) * p);
  p = Turn(y, q[1] + e[3]) * (Vector3<double>(1.250 + e[4], 0, 0) + Turn(x, e[5]) * Turn(z, e[6]) * p);
  p = Turn(z, q[0]) * (Vector3<double>(0.350 + e[0], e[1], 0) + Turn(x, e[2]) * p);
  return p + Vector3<double>(0, 0, 0.750);
}

struct Kr270Design {
  int configurations = 18;
  int stations = 2;  // configurations are shared out in turn
  std::uint64_t seed = 1;
  double sigma = 1e-4;  // m, stated in every row
};

// One row per marker, the first `markers` of the data, without points.
inline void AddShot(Shot shot, int markers, double sigma, Measurements* data) {
  shot.observations.clear();
  for (int m = 0; m < markers; ++m) {
    Observation observation;
    observation.shot = static_cast<int>(data->shots.size());
    observation.marker = m;
    observation.sigma.setConstant(sigma);
    observation.file = 0;
    observation.row = static_cast<int>(data->observations.size());
    data->files[0].rows.push_back({observation.row + 2, {}});
    shot.observations.push_back(observation.row);
    data->observations.push_back(observation);
  }
  data->shots.push_back(shot);
}

inline Measurements DesignMeasurements(const Kr270Design& design) {
  RandomNumbers random(design.seed);
  Measurements data;
  data.files.resize(1);
  data.files[0].path = "simulated.csv";
  for (int s = 0; s < design.stations; ++s) data.stations.push_back("S" + std::to_string(s + 1));
  data.markers = {"P1", "P2", "P3"};
  const double low[6] = {-150, -140, -100, -170, -110, -170}, high[6] = {150, 0, 140, 170, 110, 170};
  for (int c = 0; c < design.configurations; ++c) {
    Configuration configuration;
    configuration.id = "C" + std::to_string(c);
    configuration.q.resize(6);
    for (int j = 0; j < 6; ++j) configuration.q[j] = random.Uniform(low[j], high[j]) * kDegree;
    Shot shot;
    shot.configuration = c;
    shot.station = c % design.stations;
    data.configurations.push_back(configuration);
    AddShot(shot, 3, design.sigma, &data);
  }
  return data;
}

inline Eigen::Matrix3d BaseRotation(const Kr270Truth& truth, int station) {
  const Vector3<double>& turn = truth.base_rotvec[station];
  const double angle = turn.norm();
  return angle > 0 ? Turn(turn / angle, angle) : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

// Of an arm at q, as its station sees it.
inline Vector3<double> ExactPoint(const Kr270Truth& truth, const Eigen::VectorXd& q, int marker, int station) {
  const Vector3<double> in_base = IndependentKr270Point(q, truth.errors, truth.tools[marker]);
  return truth.base_xyz[station] + BaseRotation(truth, station) * in_base;
}

// Of every shot the reading of the first marker alone.
inline void KeepFirstMarker(Measurements* data) {
  data->markers.resize(1);
  std::vector<Observation> first;  // of each shot
  for (Shot& shot : data->shots) {
    first.push_back(data->observations[static_cast<size_t>(shot.observations.front())]);
    shot.observations = {static_cast<int>(first.size()) - 1};
  }
  data->observations = first;
}

// Rows of a design, without points, with every configuration seen from both stations.
inline Measurements SeenFromBothStations(Kr270Design design) {
  design.stations = 2;
  Measurements data = DesignMeasurements(design);
  const std::vector<Shot> once = data.shots;
  for (Shot shot : once) {
    shot.station = 1 - shot.station;
    AddShot(shot, 3, design.sigma, &data);
  }
  return data;
}

inline Vector3<double> ExactPoint(const Kr270Truth& truth, const Measurements& data, const Observation& row) {
  return ExactPoint(truth, data.ConfigurationOf(row).q, row.marker, data.shots[row.shot].station);
}

// Fills in the points: truth plus seeded noise of the design's sigma.
inline void MeasureKr270(const Kr270Truth& truth, double sigma, std::uint64_t seed, Measurements* data) {
  NormalNumbers normal(seed);
  for (Observation& observation : data->observations) {
    const Vector3<double> noise = test::RandomVector(normal);
    observation.point_in_station = ExactPoint(truth, *data, observation) + sigma * noise;
  }
}

inline CalibrationProblem Kr270ProblemOf(const Measurements& data, const Experiment& experiment) {
  Robot robot;
  robot.name = "KR 270";
  robot.chain = Kr270Chain();
  return MakeCalibrationProblem(robot, data, experiment);
}

inline CalibrationProblem Kr270Problem(const Kr270Design& design, const Kr270Truth& truth, std::uint64_t noise_seed) {
  Measurements data = DesignMeasurements(design);
  MeasureKr270(truth, design.sigma, noise_seed, &data);
  return Kr270ProblemOf(data, Experiment());
}

// The truth of a coordinate by name, as results state it (SI).
inline double TrueValue(const Kr270Truth& truth, const std::string& name) {
  const auto axis_of = [](char c) { return c - 'x'; };
  if (name.rfind("geometry/", 0) == 0) {
    for (size_t i = 0; i < 18; ++i) {
      if (name.substr(9) == Kr270Errors()[i]) return truth.errors[i];
    }
  }
  const char last = name.back();
  if (name.rfind("marker/P", 0) == 0) return truth.tools[name[8] - '1'][axis_of(last)];
  const int station = name[6] - '1';  // base/S1/rx
  const bool turns = name[name.size() - 2] == 'r';
  return (turns ? truth.base_rotvec : truth.base_xyz)[station][axis_of(last)];
}

}  // namespace sagitta::test
