// Campaigns on a UR5 whose table is not the nominal one, from any place and with any tool: kinematics of
// tests/support/measured_arms.h.
#pragma once

#include <string>
#include <vector>

#include "models/geometry.h"
#include "problems/simulation.h"
#include "tests/support/measured_arms.h"
#include "tests/support/random_vector.h"

namespace sagitta::test {

struct DhCampaign {
  std::vector<DhRow> nominal = Ur5Rows();
  std::vector<DhRow> rows = Ur5WithErrors();
  std::vector<double> slip_mrad = {0, 0, 0, 0, 0, 0};
  Vector3<double> base_xyz{2.3, -0.8, 0.41};
  Vector3<double> base_rotvec{0.02, -0.01, 1.1};
  std::vector<Vector3<double>> tools = {{0.04, 0.01, 0.06}, {-0.045, 0.025, 0.065}, {0.005, -0.05, 0.05}};
  std::string station = "S1";
  std::vector<std::string> markers = {"P1", "P2", "P3"};
  int configurations = 40;
  double sigma = 3e-5;  // m
  double scale = 1.0;   // of all that the instrument measures
  std::uint64_t seed = 1;

  static std::vector<DhRow> Ur5WithErrors() {
    std::vector<DhRow> rows = Ur5Rows();
    rows[1].a += 0.3e-3, rows[2].a += 0.25e-3, rows[4].d += 0.3e-3, rows[3].a -= 0.1e-3;
    rows[0].alpha_deg += 0.015, rows[4].alpha_deg += 0.025, rows[1].theta_deg += 0.02, rows[3].theta_deg -= 0.045;
    return rows;
  }
};

// Other poses and other noise for every seed.
inline Measurements MeasurementsOf(const DhCampaign& campaign) {
  RandomNumbers random(campaign.seed);
  NormalNumbers normal(7000 + campaign.seed);
  Measurements data;
  data.files.resize(1);
  data.files[0].path = "arm.csv";
  data.stations = {campaign.station};
  data.markers = campaign.markers;
  const double low[6] = {-120, -130, -110, -120, -100, -150}, high[6] = {120, -30, 110, 60, 100, 150};
  for (int c = 0; c < campaign.configurations; ++c) {
    Eigen::VectorXd q(campaign.rows.size());
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    for (size_t j = 0; j < campaign.rows.size(); ++j) {
      q[j] = random.Uniform(low[j], high[j]) * kDegree;
      pose = pose * Link(campaign.rows[j], q[j] + 1e-3 * campaign.slip_mrad[j]);
    }
    data.configurations.push_back({"C" + std::to_string(c), q, false});
    Shot shot;
    shot.configuration = c;
    shot.station = 0;
    for (size_t m = 0; m < campaign.tools.size(); ++m) {
      Observation row;
      row.shot = c;
      row.marker = static_cast<int>(m);
      row.sigma.setConstant(campaign.sigma);
      row.file = 0;
      row.row = static_cast<int>(data.observations.size());
      const Vector3<double> in_base = (pose * campaign.tools[m].homogeneous()).head<3>();
      row.point_in_station = campaign.base_xyz + RotationFromVector(campaign.base_rotvec) * in_base;
      row.point_in_station = campaign.scale * row.point_in_station + campaign.sigma * RandomVector(normal);
      data.files[0].rows.push_back({row.row + 2, {}});
      shot.observations.push_back(row.row);
      data.observations.push_back(row);
    }
    data.shots.push_back(shot);
  }
  return data;
}

// The same with the nominal table.
inline CalibrationProblem ProblemOf(const DhCampaign& campaign) {
  return ProblemOf(campaign.nominal, MeasurementsOf(campaign));
}

}  // namespace sagitta::test
