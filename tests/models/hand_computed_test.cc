// Numbers computed by hand of the arm of two links: nodes of a compliance, what turns a measured rotation, wrenches
// that turn with the flange, units of results.
#include <gtest/gtest.h>

#include "models/constants.h"
#include "models/quantity.h"
#include "tests/support/two_link.h"

namespace sagitta::hand_computed_test {
namespace {

using test::TwoLinkScene;

// J2 at -0.05 rad between nodes at -0.2 (1 urad/Nm) and 0.4 (3 urad/Nm): a quarter of the way, 1.5 urad/Nm. 100 N down
// at the flange turn the boom by k 40 N m cos(lift), lift = q2 - deflection.
TEST(HandComputed, ComplianceBetweenTwoNodes) {
  for (const auto& [q, k] : {std::make_pair(-0.05, 1.5e-6), std::make_pair(-0.7, 1e-6), std::make_pair(0.9, 3e-6),
                             std::make_pair(0.25, 2.5e-6)}) {
    TwoLinkScene scene;
    scene.robot.compliances.push_back({1, {{-0.2, 1e-6}, {0.4, 3e-6}}, true});
    scene.shot().q[1] = q;
    scene.Load({0.0, 0.0, -100.0});
    double lift = q;
    for (int i = 0; i < 50; ++i) lift = q - k * 40.0 * std::cos(lift);
    test::ExpectPoint(scene.Seen(), 1.0 + 0.4 * std::cos(lift), 0.0, 0.5 + 0.4 * std::sin(lift), 1e-13);
  }
}

TEST(HandComputed, ValuesGoBackIntoTheRobot) {
  Robot robot = test::TwoLink();
  robot.compliances = {{0, {{0.0, 5e-6}}, false}, {1, {{-0.2, 1e-6}, {0.4, 3e-6}}, true}};
  robot.effects = {{"encoder_gain", "J2", {}, {0.0}}};
  const ForwardModel model(robot);
  std::vector<double> theta = model.NominalValues();
  for (int i = 0; i < model.num_parameters(); ++i) theta[i] = 1e-3 * (i + 1);
  std::map<std::string, double> of;
  for (int i = 0; i < model.num_parameters(); ++i) of[model.parameters()[i].name] = theta[i];
  const Robot valued = model.WithValues(theta);
  EXPECT_EQ(valued.compliances[0].nodes[0].k, of.at("compliance/J1"));
  EXPECT_EQ(valued.compliances[1].nodes[0].k, of.at("compliance/J2@-11.4592"));
  EXPECT_EQ(valued.compliances[1].nodes[1].k, of.at("compliance/J2@22.9183"));
  EXPECT_EQ(valued.effects[0].values[0], of.at("effect/encoder_gain/J2/gain"));
  EXPECT_EQ(valued.chain.transforms[valued.chain.FindError("a1")].nominal, 1.0 + of.at("geometry/a1"));
}

// FORMATS: the unit is in the name, its SI value is not a matter of opinion.
TEST(HandComputed, UnitsOfResults) {
  const std::map<std::string, double> si = {{"mm", 1e-3},
                                            {"deg", 3.14159265358979323846 / 180},
                                            {"mrad", 1e-3},
                                            {"urad", 1e-6},
                                            {"um", 1e-6},
                                            {"urad/Nm", 1e-6},
                                            {"um/N", 1e-6},
                                            {"N/mm", 1000.0},
                                            {"urad/kNm3", 1e-15},  // urad per (1000 N m)^3
                                            {"ppm", 1e-6},
                                            {"kg", 1.0},
                                            {"kgm", 1.0},
                                            {"um/h", 1e-6 / 3600},
                                            {"urad/h", 1e-6 / 3600},
                                            {"ppm/K", 1e-6},
                                            {"urad/m", 1e-6}};
  for (const auto& [unit, value] : si) EXPECT_NEAR(SiPerUnit(unit), value, 1e-12 * value) << unit;
  for (int i = 0; i < static_cast<int>(Quantity::kCount); ++i) {
    const std::string unit = TraitsOf(static_cast<Quantity>(i)).unit;
    EXPECT_EQ(si.count(unit), 1u) << unit;
  }
}

// An instrument that has turned by a fifth of a radian: the derivative of the rotation it reads, by differences.
TEST(HandComputed, RotationReadByAnInstrumentThatHasTurnedFar) {
  Robot robot = test::TwoLink();
  robot.effects = {{"station_drift", "S1", {}, std::vector<double>(6, 0.0)}};
  const ForwardModel model(robot, {"T"});
  ShotInput shot(Eigen::VectorXd::Zero(2));
  shot.conditions.q << 0.3, -0.4;
  shot.conditions.station = "S1";
  shot.conditions.has_time = true;
  shot.conditions.station_time = 100.0;
  model.Prepare(&shot);
  Pose<double> base;
  base.rotation = RotationFromVector(Vector3<double>(0.4, -0.9, 1.3));
  MarkerInFrame target{model.chain().FlangeFrame(), {0.1, 0.2, 0.3}, 0, ReadingKind::kRotation};
  target.rotation = RotationFromVector(Vector3<double>(-0.2, 0.5, 0.8));
  std::vector<double> theta = model.NominalValues();
  std::vector<int> turns;
  for (int i = 0; i < model.num_parameters(); ++i) {
    const std::string& name = model.parameters()[i].name;
    if (name.rfind("effect/station_drift", 0) != 0 || name[name.size() - 2] != 'r') continue;
    theta[i] = 1e-3 * (turns.size() + 1.0);  // 0.1, 0.2 and 0.3 rad
    turns.push_back(i);
  }
  ASSERT_EQ(turns.size(), 3u);
  const auto read = [&] {
    std::vector<PointPrediction> prediction;
    EXPECT_TRUE(model.Predict(shot, theta.data(), turns, base, {target}, &prediction));
    return prediction[0];
  };
  const PointPrediction here = read();
  constexpr double kStep = 1e-7;
  for (size_t c = 0; c < turns.size(); ++c) {
    Matrix3<double> side[2];
    for (const int s : {0, 1}) {
      theta[turns[c]] += s == 0 ? kStep : -2.0 * kStep;
      side[s] = RotationFromVector(read().point);
    }
    theta[turns[c]] += kStep;
    const Vector3<double> slope = RotationVector(Matrix3<double>(side[0] * side[1].transpose())) / (2.0 * kStep);
    EXPECT_LT((slope - here.d_theta.col(static_cast<int>(c))).norm(), 1e-5 * slope.norm()) << c;
  }
}

// A force that turns with the flange of an arm that bends by a tenth of a radian: the point's derivative by the joints'
// deviations, by differences. (What the force does as it turns is a tenth of it.)
TEST(HandComputed, AForceThatTurnsWithTheFlange) {
  Robot robot = test::TwoLink();
  robot.compliances = {{0, {{0.0, 4e-4}}, false}, {1, {{0.0, 6e-4}}, false}};
  const ForwardModel model(robot, {"M1"});
  ShotInput shot(Eigen::VectorXd::Zero(2));
  shot.conditions.q << 0.3, 0.5;
  shot.wrenches = {{model.chain().FlangeFrame(),
                    {0.1, 0.05, -0.2},
                    {150.0, 120.0, -300.0},
                    {10.0, -20.0, 30.0},
                    WrenchFrame::kFlange}};
  model.Prepare(&shot);
  const std::vector<double> theta = model.NominalValues();
  const MarkerInFrame marker{model.chain().FlangeFrame(), {0.05, 0.3, 0.1}, 0};
  std::vector<PointPrediction> prediction;
  const auto at = [&](const Eigen::Vector2d& deviation) {
    EXPECT_TRUE(model.Predict(shot, theta.data(), {}, Pose<double>(), {marker}, &prediction, deviation.data()));
    return prediction[0];
  };
  const PointPrediction here = at(Eigen::Vector2d::Zero());
  const Equilibrium state = model.Equilibrate(shot, theta.data(), Matrix3<double>::Identity());
  EXPECT_GT((state.torque.array() * Eigen::Array2d(4e-4, 6e-4)).abs().maxCoeff(), 0.02);
  constexpr double kStep = 1e-6;
  for (int j = 0; j < 2; ++j) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(j);
    const Vector3<double> slope = (at(step).point - at(-step).point) / (2.0 * kStep);
    EXPECT_LT((slope - here.d_latent.col(j)).norm(), 1e-6 * slope.norm()) << j;
  }
}

}  // namespace
}  // namespace sagitta::hand_computed_test
