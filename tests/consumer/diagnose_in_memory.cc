// No files: an arm, poses and readings made here; an encoder error of joint 2 is hidden in them and found.
#include <sagitta/sagitta.h>

#include <cmath>
#include <iostream>

namespace {

sagitta::Robot Arm() {
  return sagitta::ReadRobotText(R"(
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

constexpr int kPoses = 60;
constexpr double kSigma = 2e-5;   // m
constexpr double kHidden = 3e-4;  // rad, cos(q2) of joint 2's encoder

sagitta::Measurements Readings(const sagitta::Robot& robot) {
  const sagitta::Vector3<double> points[] = {{0.05, 0.0, 0.1}, {-0.03, 0.06, 0.12}, {0.0, -0.05, 0.15}};
  const sagitta::ForwardModel model(robot.chain);
  const std::vector<double> no_errors(model.num_parameters(), 0.0);
  sagitta::NormalNumbers normal(11);
  sagitta::Measurements data;
  data.stations = {"S1"};
  data.markers = {"M1", "M2", "M3"};
  for (int i = 0; i < kPoses; ++i) {
    sagitta::Configuration configuration;
    configuration.id = "c" + std::to_string(i);
    configuration.q = Eigen::VectorXd(6);
    for (double& angle : configuration.q) angle = std::max(-1.5, std::min(1.5, 0.7 * normal()));
    Eigen::VectorXd actual = configuration.q;
    actual[1] += kHidden * std::cos(configuration.q[1]);
    sagitta::Shot shot;
    shot.configuration = i;
    shot.station = 0;
    for (int m = 0; m < 3; ++m) {
      sagitta::Observation row;
      row.shot = i;
      row.marker = m;
      row.point_in_station =
          model.PointInBase(sagitta::ShotInput(actual), no_errors.data(), robot.chain.FlangeFrame(), points[m]);
      for (double& coordinate : row.point_in_station) coordinate += kSigma * normal();
      row.sigma.setConstant(kSigma);
      shot.observations.push_back(static_cast<int>(data.observations.size()));
      data.observations.push_back(row);
    }
    data.configurations.push_back(configuration);
    data.shots.push_back(shot);
  }
  return data;
}

}  // namespace

int main() {
  const sagitta::Robot robot = Arm();
  sagitta::Experiment experiment;
  experiment.validation.kind = sagitta::ValidationSpec::Kind::kFraction;
  experiment.validation.fraction = 0.3;
  const sagitta::Diagnosis diagnosis =
      sagitta::Diagnose(sagitta::MakeCalibrationProblem(robot, Readings(robot), experiment), {});
  std::cout << sagitta::WordOf(diagnosis.verdict) << ", " << diagnosis.effects.size() << " effect(s)\n";
  return diagnosis.verdict == sagitta::DiagnosisVerdict::kExplained && diagnosis.effects.size() == 1 ? 0 : 1;
}
