// Loaded arms: equilibrium, torques and exact derivatives.
#include "models/elastostatics.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "models/forward_model.h"
#include "tests/support/arms.h"
#include "tests/support/kr270.h"
#include "tests/support/paths.h"
#include "tests/support/ridders.h"

namespace sagitta::elastostatics_test {
namespace {

using test::RandomNumbers;

constexpr int kMaxUnknowns = 64;
using Jet = ceres::Jet<double, kMaxUnknowns>;

Robot ElasticKr270() {
  Robot robot;
  robot.chain = test::Kr270Chain();
  const double k[6] = {0.623e-6, 0.287e-6, 0.416e-6, 2.786e-6, 3.483e-6, 2.074e-6};
  for (int j = 0; j < 6; ++j) robot.compliances.push_back({j, {{0.0, k[j]}}, false});
  return robot;
}

Robot Kr270WithSpring(bool preload) {
  Robot robot = ElasticKr270();
  robot.gravity_compensator = GravityCompensator{1, 0.18472, 0.68593, 0.12330, 0.458, 1.5e4, preload};
  robot.compliances[2] = {2, {{-0.5, 0.41e-6}, {0.7, 0.42e-6}, {1.5, 0.40e-6}}, true};
  return robot;
}

Robot ElasticSevenAxis() {
  Robot robot;
  robot.chain = test::DhArm(DhConvention::kModified, {{0, 0, 0.36, 0},
                                                      {0, -90, 0, 10},
                                                      {0, 90, 0.42, 0},
                                                      {0, 90, 0, 0},
                                                      {0, -90, 0.4, 0},
                                                      {0, -90, 0, 5},
                                                      {0.08, 90, 0.12, 0}});
  for (int j = 0; j < 7; ++j) robot.compliances.push_back({j, {{0.0, (1.0 + j) * 1e-6}}, false});
  return robot;
}

Robot ElasticGantry() {  // prismatic first axis, soft; one joint's sign reversed
  Robot robot;
  robot.chain =
      test::DhArm(DhConvention::kStandard,
                  {{0.1, -90, 0, 0, JointType::kPrismatic}, {0.3, 0, 0.1, 20}, {0.5, 90, 0, 0}, {0, 0, 0.4, 0}});
  for (ElementaryTransform& transform : robot.chain.transforms) {
    if (transform.joint == 2) transform.sign = -1.0;
  }
  robot.chain.couplings.push_back({2, 1, 1.0});
  robot.compliances.push_back({0, {{0.0, 3e-7}}, false});
  robot.compliances.push_back({2, {{0.0, 2e-6}}, false});
  return robot;
}

Robot ElasticScara() {  // a soft prismatic axis that two rotations carry, with joints beyond it
  Robot robot;
  robot.chain = test::DhArm(
      DhConvention::kStandard,
      {{0.4, 30, 0.3, 0}, {0.3, 60, 0, 20}, {0.05, -40, 0.2, 10, JointType::kPrismatic}, {0.1, 20, 0.1, 0}});
  for (int j = 0; j < 4; ++j) robot.compliances.push_back({j, {{0.0, (1.0 + j) * 1e-6}}, false});
  return robot;
}

struct LoadedCase {
  std::string name;
  Robot robot;
  WrenchFrame frame;
};

std::vector<LoadedCase> Cases() {
  return {{"kr270", ElasticKr270(), WrenchFrame::kMeasurement},
          {"kr270_base", ElasticKr270(), WrenchFrame::kBase},
          {"kr270_flange", ElasticKr270(), WrenchFrame::kFlange},
          {"spring", Kr270WithSpring(true), WrenchFrame::kMeasurement},
          {"spring_without_preload", Kr270WithSpring(false), WrenchFrame::kMeasurement},
          {"seven_axis", ElasticSevenAxis(), WrenchFrame::kFlange},
          {"gantry", ElasticGantry(), WrenchFrame::kMeasurement},
          {"scara", ElasticScara(), WrenchFrame::kMeasurement},
          {"scara_flange", ElasticScara(), WrenchFrame::kFlange}};
}

// A heavy load with a moment, and the tool's own weight.
ShotInput RandomShot(const LoadedCase& loaded, int pose, RandomNumbers* random) {
  const Chain& chain = loaded.robot.chain;
  ShotInput shot(Eigen::VectorXd::Zero(chain.num_joints()));
  for (int j = 0; pose > 0 && j < shot.conditions.q.size(); ++j)
    shot.conditions.q[j] = random->Uniform(-1.5, 1.5);  // pose 0: stretched
  AppliedWrench load{chain.FlangeFrame(), random->Vector(0.3), random->Vector(2500.0), random->Vector(300.0),
                     loaded.frame};
  AppliedWrench weight{chain.FlangeFrame(), random->Vector(0.2), {0, 0, -400}, {0, 0, 0}, WrenchFrame::kBase};
  shot.wrenches = {load, weight};
  return shot;
}

class LoadedDerivatives : public ::testing::TestWithParam<int> {};

TEST_P(LoadedDerivatives, EqualJetsAndDifferences) {
  const LoadedCase loaded = Cases()[GetParam()];
  const ForwardModel model(loaded.robot);
  const int n = model.num_parameters();
  ASSERT_LE(n + 9, kMaxUnknowns);
  RandomNumbers random(40 + GetParam());
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  for (const double size : {0.0, 1e-8, 1e-2}) {
    for (int pose = 0; pose < 6; ++pose) {
      ShotInput shot = RandomShot(loaded, pose, &random);
      model.Prepare(&shot);
      std::vector<double> theta = model.NominalValues();
      const std::vector<double> typical = theta;
      // Neutral, 1e-8 around it, as large as they are: a rigid arm without a spring bends to first order.
      const double elastic = size == 1e-2 ? 1.0 : size;
      for (int i = 0; i < n; ++i) {
        const ParameterLaw law = model.parameters()[i].law;
        if (law == ParameterLaw::kGeometry) theta[i] += random.Uniform(-size, size);
        const bool is_rate = model.parameters()[i].name == "compensator/Kc";
        if (pose % 2 == 1 && (law == ParameterLaw::kCompliance || is_rate)) theta[i] *= elastic;
      }
      Pose<double> base;
      base.rotation = RotationFromVector<double>(random.Vector(1.5));
      base.translation = random.Vector(2.0);
      const int link = model.chain().FrameAfterJoint(1);
      for (const int frame : {model.chain().FlangeFrame(), link}) {
        const MarkerInFrame marker{frame, random.Vector(0.3)};
        std::vector<PointPrediction> prediction;
        ASSERT_TRUE(model.Predict(shot, theta.data(), all, base, {marker}, &prediction));

        Vector3<Jet> delta, point;
        std::vector<Jet> jets;
        for (int i = 0; i < 3; ++i) delta[i] = Jet(0.0, i), point[i] = Jet(marker.point[i], 3 + i);
        for (int i = 0; i < n; ++i) jets.emplace_back(theta[i], 6 + i);
        const Matrix3<Jet> rotation = RotationFromVector(delta) * base.rotation.cast<Jet>();
        const Vector3<Jet> expected =
            rotation * model.PointInBase(shot, jets.data(), frame, point, rotation) + base.translation.cast<Jet>();
        const auto column = [&](int i) {
          return Vector3<double>(expected[0].v[i], expected[1].v[i], expected[2].v[i]);
        };
        const auto near = [&](const Vector3<double>& ours, int i, const std::string& what) {
          EXPECT_LE((ours - column(i)).norm(), 1e-10 * std::max(column(i).norm(), 1e-3)) << loaded.name << " " << what;
        };
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(prediction[0].point[i], expected[i].a, 1e-12);
        for (int i = 0; i < 3; ++i) near(prediction[0].d_rotation.col(i), i, "rotation");
        for (int i = 0; i < 3; ++i) near(prediction[0].d_marker.col(i), 3 + i, "marker");
        for (int i = 0; i < n; ++i) near(prediction[0].d_theta.col(i), 6 + i, model.parameters()[i].name);

        for (int i = 0; i < n; ++i) {  // independent of Jets and of any derivative of ours
          const auto value = [&](double x) {
            std::vector<double> moved = theta;
            moved[i] = x;
            std::vector<PointPrediction> there;
            EXPECT_TRUE(model.Predict(shot, moved.data(), {}, base, {marker}, &there));
            return Eigen::VectorXd(there[0].point);
          };
          const double scale = model.parameters()[i].law == ParameterLaw::kGeometry ? 0.02 : 0.2 * std::abs(typical[i]);
          const Eigen::VectorXd difference = test::RiddersDerivative(value, theta[i], scale);
          const Eigen::VectorXd ours = prediction[0].d_theta.col(i);
          EXPECT_LE((ours - difference).norm() * scale, 1e-6 * std::max(difference.norm() * scale, 1e-5))
              << loaded.name << " " << model.parameters()[i].name;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllCases, LoadedDerivatives, ::testing::Range(0, static_cast<int>(Cases().size())),
                         [](const auto& tested) { return Cases()[tested.param].name; });

// Statics: the deflection satisfies u = k tau at the deflected arm.
TEST(Equilibrium, IsAFixedPoint) {
  const LoadedCase loaded = Cases()[3];
  const ForwardModel model(loaded.robot);
  RandomNumbers random(5);
  ShotInput shot = RandomShot(loaded, 1, &random);
  model.Prepare(&shot);
  const std::vector<double> theta = model.NominalValues();
  const Equilibrium equilibrium = model.Equilibrate(shot, theta.data(), Matrix3<double>::Identity());
  ASSERT_TRUE(equilibrium.converged);
  const std::vector<double> rigid = model.TransformValues(shot, theta.data());
  for (const ElasticTerm& term : shot.terms.elastic) {
    const int e = term.transform;
    const int slot = term.transform == model.chain().JointTransform(0) ? 0 : -1;
    if (slot < 0) continue;
    EXPECT_NEAR(equilibrium.values[e] - rigid[e], theta[term.parameter] * equilibrium.torque[slot], 1e-14);
    EXPECT_GT(std::abs(equilibrium.values[e] - rigid[e]), 1e-5);
  }
}

TEST(Equilibrium, FoldingLoadIsReportedNotReturned) {
  Robot robot = ElasticKr270();
  for (JointCompliance& compliance : robot.compliances) compliance.nodes[0].k *= 1e4;
  const ForwardModel model(robot);
  ShotInput shot(Eigen::VectorXd::Zero(6));
  shot.wrenches = {{model.chain().FlangeFrame(), {0, 0, 0}, {0, 0, -2.5e4}, {0, 0, 0}, WrenchFrame::kBase}};
  model.Prepare(&shot);
  std::vector<PointPrediction> predictions;
  EXPECT_FALSE(model.Predict(shot, model.NominalValues().data(), {}, Pose<double>(),
                             {{model.chain().FlangeFrame(), {0, 0, 0}}}, &predictions));
}

// The torque is the derivative of the spring energy U = Kc (s - s0)^2 / 2, and
// its slope is the published Kc a L eta (paper 002, eq. (11)).
TEST(GravityCompensator, TorqueIsTheSlopeOfTheSpringEnergy) {
  const CompensatorParameters<double> p{0.18472, 0.68593, 0.12330, 0.458, 6.944e6};
  const double a = std::hypot(p.a_x, p.a_y), alpha = std::atan2(p.a_x, p.a_y);
  for (const double q : {-2.4, -1.7, -0.9, 0.0, 0.4}) {
    const auto energy = [&](double x) {
      const double stretch = CompensatorSpringLength(p, x) - p.s0;
      return Eigen::VectorXd::Constant(1, 0.5 * p.Kc * stretch * stretch);
    };
    EXPECT_NEAR(CompensatorTorque(p, q), -test::RiddersDerivative(energy, q, 0.1)[0], 1e-2);
    const auto torque = [&](double x) { return Eigen::VectorXd::Constant(1, CompensatorTorque(p, x)); };
    const double gamma = alpha - q, s = CompensatorSpringLength(p, q);
    const double eta =
        p.s0 / s * (a * p.L / (s * s) * std::pow(std::sin(gamma), 2) + std::cos(gamma)) - std::cos(gamma);
    EXPECT_NEAR(test::RiddersDerivative(torque, q, 0.1)[0] / (-p.Kc * a * p.L * eta), 1.0, 1e-7);
  }
}

TEST(GravityCompensator, ScaleGaugeLeavesTheTorque) {
  const CompensatorParameters<double> p{0.18472, 0.68593, 0.12330, 0.458, 1.5e4};
  const double c = 1.3;
  const CompensatorParameters<double> scaled{c * p.L, c * p.a_x, c * p.a_y, c * p.s0, p.Kc / (c * c)};
  for (const double q : {-2.0, -1.0, 0.3}) EXPECT_NEAR(CompensatorTorque(p, q), CompensatorTorque(scaled, q), 1e-9);
}

TEST(CompensatorReference, EquivalentComplianceOfJoint2) {
  std::ifstream file(test::SharedFolder() + "/reference/kr270_reference.json");
  if (!file) GTEST_SKIP() << "no kr270_reference.json: the reference values are not part of this repository";
  const nlohmann::json c = nlohmann::json::parse(file)["comp"];
  const double a = c["a"].get<double>() * 1e-3, alpha = c["alpha"];
  const CompensatorParameters<double> p{c["L"].get<double>() * 1e-3, a * std::sin(alpha), a * std::cos(alpha),
                                        c["s0"].get<double>() * 1e-3, c["Kc_N_per_mm"].get<double>() * 1e3};
  const double k0 = c["K0_Nmm"].get<double>() * 1e-3;
  for (int i = 0; i < 5; ++i) {
    const auto torque = [&](double x) { return Eigen::VectorXd::Constant(1, CompensatorTorque(p, x)); };
    const double stiffness = k0 - test::RiddersDerivative(torque, c["q2"][i].get<double>(), 0.05)[0];
    EXPECT_NEAR(1e6 / stiffness / c["k2eff_1e9"][i].get<double>(), 1.0, 1e-7);
  }
}

// Torques at the undeflected arm and first-order loaded markers (the reference
// is first order; the equilibrium differs by up to 0.017 mm).
TEST(LoadedReference, TorquesAndFirstOrderMarkers) {
  std::ifstream file(test::SharedFolder() + "/reference/kr270_reference.json");
  if (!file) GTEST_SKIP() << "no kr270_reference.json: the reference values are not part of this repository";
  const nlohmann::json reference = nlohmann::json::parse(file);
  const auto vector = [](const nlohmann::json& v) { return Vector3<double>(v[0], v[1], v[2]); };
  Pose<double> base;
  base.translation = 1e-3 * vector(reference["base_p"]);
  base.rotation = RotationFromVector<double>(vector(reference["base_rotvec"]));
  for (int c = 0; c < 15; ++c) {
    Robot robot = ElasticKr270();
    robot.compliances[1].nodes[0].k = reference["k2_per_cfg_1e-9"][c].get<double>() * 1e-6;
    const ForwardModel model(robot);
    std::vector<double> theta = model.NominalValues();
    for (int i = 0; i < 18; ++i) {
      const bool length = model.parameters()[i].quantity == Quantity::kLength;
      theta[i] = reference["geo_mm_rad"][i].get<double>() * (length ? 1e-3 : 1.0);
    }
    ShotInput shot(Eigen::VectorXd::Zero(6));
    for (int j = 0; j < 6; ++j) shot.conditions.q[j] = reference["q_deg"][c][j].get<double>() * kDegree;
    const AppliedWrench wrench{model.chain().FlangeFrame(),
                               1e-3 * vector(reference["load_point_tool"]),
                               vector(reference["force_tracker"]),
                               {0, 0, 0},
                               WrenchFrame::kMeasurement};
    std::vector<double> values = model.TransformValues(shot, theta.data());
    ChainState<double> state;
    EvaluateChain(model.chain(), values.data(), &state);
    const WrenchInBase<double> in_base = ToBase(wrench, state, base.rotation);
    for (int j = 0; j < 6; ++j) {
      const int slot = model.chain().JointTransform(j);
      const double torque = GeneralisedForce(model.chain(), state, slot, in_base);
      EXPECT_NEAR(torque * 1e3 / reference["tau_Nmm"][c][j].get<double>(), 1.0, 1e-9);
      values[slot] += robot.compliances[j].nodes[0].k * torque;
    }
    EvaluateChain(model.chain(), values.data(), &state);
    shot.wrenches = {wrench};
    model.Prepare(&shot);
    for (int m = 0; m < 3; ++m) {
      const Vector3<double> tool = 1e-3 * vector(reference["tool"][m]);
      const Vector3<double> expected = vector(reference["markers_loaded_first_order_theta"][c][m]);
      EXPECT_LT((1e3 * (base * (state.frames.back() * tool)) - expected).norm(), 1e-9);
      std::vector<PointPrediction> equilibrium;
      ASSERT_TRUE(model.Predict(shot, theta.data(), {}, base, {{model.chain().FlangeFrame(), tool}}, &equilibrium));
      EXPECT_LT((1e3 * equilibrium[0].point - expected).norm(), 0.05);  // close, and not the same
      EXPECT_GT((1e3 * equilibrium[0].point - expected).norm(), 1e-6);
    }
  }
}

}  // namespace
}  // namespace sagitta::elastostatics_test
