// Measured torques in place of the modelled ones, against deflections computed by hand.
#include <gtest/gtest.h>

#include <numeric>

#include "models/forward_model.h"
#include "tests/support/arms.h"
#include "tests/support/ridders.h"

namespace sagitta::stated_torque_test {
namespace {

// Two links of 1 m and 0.5 m in the x-y plane; joint 2 counts against its axis.
Robot PlanarArm() {
  Robot robot;
  robot.chain.joints = test::Revolutes(2);
  robot.chain.transforms = {test::OnJoint(Motion::kRotation, Axis::kZ, 0, "dq1"), test::Translate(Axis::kX, 1.0, "a1"),
                            test::OnJoint(Motion::kRotation, Axis::kZ, 1, "dq2", -1.0),
                            test::Translate(Axis::kX, 0.5, "a2")};
  robot.compliances = {{0, {{0.0, 2e-6}}, false}, {1, {{0.0, 5e-6}}, false}};
  return robot;
}

ShotInput ShotWith(double q1, double q2, double tau1, double tau2) {
  ShotInput shot(Eigen::Vector2d(q1, q2));
  shot.conditions.joint_torques = Eigen::Vector2d(tau1, tau2);
  return shot;
}

Vector3<double> Tip(double first, double both) {
  return {std::cos(first) + 0.5 * std::cos(both), std::sin(first) + 0.5 * std::sin(both), 0.0};
}

Vector3<double> Predicted(const ForwardModel& model, const ShotInput& shot, const std::vector<double>& theta) {
  std::vector<PointPrediction> prediction;
  EXPECT_TRUE(model.Predict(shot, theta.data(), {}, Pose<double>(),
                            {{model.chain().FlangeFrame(), Vector3<double>::Zero(), 0}}, &prediction));
  return prediction[0].point;
}

TEST(StatedTorque, DrivesComplianceAboutTheJointsPositiveDirection) {
  const ForwardModel model(PlanarArm());
  // Deflections of the joints: q1 + 2e-6 * 300 = q1 + 6e-4; q2 - 5e-6 * 80 = q2 - 4e-4, and the second turns by -q2.
  const Vector3<double> tip = Predicted(model, ShotWith(0.3, 0.8, 300.0, -80.0), model.NominalValues());
  const double first = 0.3 + 6e-4, second = 0.8 - 4e-4;
  EXPECT_LT((tip - Tip(first, first - second)).norm(), 1e-14);
}

TEST(StatedTorque, NothingElseCountsOnItsJoint) {
  Robot robot = PlanarArm();
  const ForwardModel model(robot);
  ShotInput loaded = ShotWith(0.3, 0.8, 300.0, -80.0);
  loaded.wrenches = {{model.chain().FlangeFrame(), {0, 0, 0}, {400.0, -900.0, 50.0}, {10, 20, 30}}};
  const std::vector<double> theta = model.NominalValues();
  EXPECT_EQ(Predicted(model, loaded, theta), Predicted(model, ShotWith(0.3, 0.8, 300.0, -80.0), theta));
  ShotInput unstated = loaded;
  unstated.conditions.joint_torques.resize(0);
  EXPECT_GT((Predicted(model, unstated, theta) - Predicted(model, loaded, theta)).norm(), 1e-4);
}

TEST(StatedTorque, DrivesEveryLawOfTheJointAlike) {
  Robot robot = PlanarArm();
  robot.effects = {{"compliance_hardening", "j1", {}, {3e-12}}, {"backlash", "j2", {{"by", "torque"}}, {7e-5}}};
  const ForwardModel model(robot);
  const std::vector<double> theta = model.NominalValues();
  // 2e-6 * 300 + 3e-12 * 300^3 = 6e-4 + 8.1e-5;  -(5e-6 * 80 + 7e-5) = -4.7e-4
  const Vector3<double> tip = Predicted(model, ShotWith(0.3, 0.8, 300.0, -80.0), theta);
  const double first = 0.3 + 6.81e-4, second = 0.8 - 4.7e-4;
  // The gap of backlash is of the transform: it turns with the sign of the torque about it.
  EXPECT_LT((tip - Tip(first, first - second)).norm(), 1e-13);
}

TEST(StatedTorque, DerivativesEqualDifferencesAndKnowNoGeometry) {
  Robot robot = PlanarArm();
  robot.effects = {{"compliance_hardening", "j1", {}, {3e-12}},
                   {"transverse_compliance", "j1", {}, {1e-6, 2e-6}},
                   {"link_gravity", "j2", {}, {50.0, 5.0, 1.0, 2.0}}};
  robot.gravity_compensator = GravityCompensator{0, 0.18472, 0.68593, 0.12330, 0.458, 1.5e4, true};
  const ForwardModel model(robot);
  ShotInput shot = ShotWith(0.3, 0.8, 300.0, -80.0);
  shot.wrenches = {{model.chain().FlangeFrame(), {0.1, 0.2, 0.1}, {400.0, -900.0, 50.0}, {10, 20, 30}}};
  model.Prepare(&shot);
  const std::vector<double> theta = model.NominalValues();
  std::vector<int> all(theta.size());
  std::iota(all.begin(), all.end(), 0);
  Pose<double> base;
  base.rotation = RotationFromVector(Vector3<double>(0.2, -0.4, 0.3));
  const MarkerInFrame marker{model.chain().FlangeFrame(), {0.1, -0.2, 0.05}, 0};
  std::vector<PointPrediction> here;
  ASSERT_TRUE(model.Predict(shot, theta.data(), all, base, {marker}, &here));
  for (size_t i = 0; i < theta.size(); ++i) {
    const ModelParameter& parameter = model.parameters()[i];
    const double step = std::max(1e-3 * std::abs(theta[i]), 1e-2 * TraitsOf(parameter.quantity).hold_limit);
    const Eigen::VectorXd numeric = test::RiddersDerivative(
        [&](double x) -> Eigen::VectorXd {
          std::vector<double> moved = theta;
          moved[i] = x;
          std::vector<PointPrediction> there;
          EXPECT_TRUE(model.Predict(shot, moved.data(), {}, base, {marker}, &there));
          return there[0].point;
        },
        theta[i], step);
    EXPECT_LE((here[0].d_theta.col(static_cast<long>(i)) - numeric).norm(), 1e-7 * std::max(numeric.norm(), 1e-3))
        << parameter.name;
    if (parameter.law == ParameterLaw::kCompensator) {
      EXPECT_TRUE(here[0].d_theta.col(static_cast<long>(i)).isZero(0.0)) << "its torque is in the measured one";
    }
  }
}

TEST(StatedTorque, ModelledTorquesAreThoseOfTheLoads) {
  Robot robot = PlanarArm();
  robot.compliances.clear();
  const ForwardModel model(robot);
  ShotInput shot = ShotWith(0.0, M_PI / 2, 1.0, 2.0);
  // Joint 2 counts backwards: the arm goes along x, then along -y; a force of 100 N along x at its end.
  shot.wrenches = {{model.chain().FlangeFrame(), {0, 0, 0}, {100.0, 0, 0}, {0, 0, 0}, WrenchFrame::kBase}};
  const Eigen::VectorXd torques =
      model.ModelledJointTorques(shot, model.NominalValues().data(), Matrix3<double>::Identity());
  // (1, -0.5) x (100, 0) = 50 about z; the same about joint 2, (0, -0.5) x (100, 0) = 50, against its direction.
  EXPECT_NEAR(torques[0], 50.0, 1e-12);
  EXPECT_NEAR(torques[1], -50.0, 1e-12);
}

}  // namespace
}  // namespace sagitta::stated_torque_test
