// Poses of a target on the flange of a KR-270, by the generator of kr270_experiment.h.
#pragma once

#include "tests/support/loaded_kr270.h"

namespace sagitta::test {

struct TargetTruth {
  Vector3<double> point = Vector3<double>(0.27, -0.05, 0.09);  // m, flange frame
  Eigen::Matrix3d rotation = Turn(Eigen::Vector3d(1, -2, 0.5).normalized(), 1.2);
};

// One row per configuration, a pose of the target "T".
inline Measurements PoseRows(const Kr270Design& design) {
  Measurements data = DesignMeasurements(design);
  const std::vector<Shot> shots = data.shots;
  data.shots.clear();
  data.observations.clear();
  data.files[0].rows.clear();
  data.markers = {"T"};
  for (const Shot& shot : shots) {
    AddShot(shot, 1, design.sigma, &data);
    data.observations.back().row = static_cast<int>(data.files[0].rows.size()) - 1;
    data.AddRotation(static_cast<int>(data.observations.size()) - 1)
        .mutable_rotation()
        ->sigma.setConstant(10.0 * design.sigma);
  }
  return data;
}

// station_from_target of every shot, without noise; values: of the joints, deflections included.
inline Pose<double> ExactPose(const Kr270Truth& truth, const TargetTruth& target, const Eigen::VectorXd& q,
                              int station) {
  std::array<double, 6> values{};
  for (int j = 0; j < 6; ++j) values[j] = q[j];
  values[1] += truth.errors[3];
  values[2] += truth.errors[7];
  values[3] += truth.errors[11];
  values[4] += truth.errors[15];
  const ArmState arm = StateOfArm(values, truth.errors);
  const Eigen::Matrix3d base = BaseRotation(truth, station);
  Pose<double> pose;
  pose.rotation = base * arm.flange * target.rotation;
  pose.translation = truth.base_xyz[station] + base * (arm.flange_origin + arm.flange * target.point);
  return pose;
}

inline Kr270Truth TurnedTruth() {
  Kr270Truth truth;
  truth.base_rotvec = {{0.0528, 0.01, 0.3}, {-0.04, 0.02, -1.0}};
  truth.base_xyz = {{0.1, 0.2, 0.3}, {3.0, -1.0, 0.2}};
  return truth;
}

// Of points, m, and of rotations, rad.
struct PoseNoise {
  double point, rotation;
};

// One pose per configuration of a robot whose base is turned, with noise; `stated` stands in the rows.
inline Measurements NoisyPoses(int configurations, const PoseNoise& stated, const PoseNoise& scatter, unsigned seed) {
  Kr270Design design;
  design.configurations = configurations;
  const Kr270Truth truth = TurnedTruth();
  const TargetTruth target;
  NormalNumbers normal(seed);
  Measurements data = PoseRows(design);
  for (Observation& row : data.observations) {
    row.sigma.setConstant(stated.point);
    row.mutable_rotation()->sigma.setConstant(row.is_point() ? 0.0 : stated.rotation);
    if (!row.is_point()) continue;
    const Pose<double> exact = ExactPose(truth, target, data.ConfigurationOf(row).q, data.shots[row.shot].station);
    Vector3<double> off, turn;
    for (int i = 0; i < 3; ++i) off[i] = scatter.point * normal();
    for (int i = 0; i < 3; ++i) turn[i] = scatter.rotation * normal();
    Observation& partner = data.observations[row.partner];
    row.point_in_station = partner.point_in_station = exact.translation + off;
    partner.mutable_rotation()->in_station = RotationFromVector(turn) * exact.rotation;
  }
  return data;
}

// Shoots a pose once more, as it was read before. The place of its point; its rotation is the next one.
inline int AppendRepeat(int pose, Measurements* data) {
  Shot shot = data->shots[pose];
  shot.repeat = "2";
  const int point = static_cast<int>(data->observations.size());
  for (const int i : data->shots[pose].observations) {
    Observation row = data->observations[i];
    row.shot = static_cast<int>(data->shots.size());
    row.partner = row.is_point() ? point + 1 : point;
    data->observations.push_back(row);
  }
  shot.observations = {point, point + 1};
  data->shots.push_back(shot);
  return point;
}

}  // namespace sagitta::test
