// Rotations of targets: predictions against products of rotation matrices, derivatives against differences.
#include <gtest/gtest.h>

#include <numeric>

#include "models/forward_model.h"
#include "tests/support/kr270.h"
#include "tests/support/ridders.h"

namespace sagitta::pose_reading_test {
namespace {

using test::RandomNumbers;

// An arm that gives way, with effects of every law: slots, torques, wrenches, marker, arm and station.
Robot ArmWithEffects() {
  Robot robot;
  robot.chain = test::Kr270Chain();
  robot.chain.joints[2].min = -2.0, robot.chain.joints[2].max = 2.5;
  const double k[6] = {0.623e-6, 0.287e-6, 0.416e-6, 2.786e-6, 3.483e-6, 2.074e-6};
  for (int j = 0; j < 6; ++j) robot.compliances.push_back({j, {{0.0, k[j]}}, false});
  robot.gravity_compensator = GravityCompensator{1, 0.18472, 0.68593, 0.12330, 0.458, 1.5e4, true};
  robot.effects = {{"transverse_compliance", "A2", {}, {2e-7, 3e-7}},
                   {"joint_harmonic", "A3", {{"order", "2"}}, {3e-4, -2e-4}},
                   {"axis_wobble", "A1", {{"order", "1"}}, {1e-4, 2e-4, -1e-4, 3e-4}},
                   {"link_gravity", "A3", {}, {200.0, 30.0, 10.0, -5.0}},
                   {"base_compliance", "base", {}, {1e-7, 2e-7}},
                   {"thermal_growth", "robot", {}, {1.2e-5}},
                   {"station_drift", "S1", {}, {1e-8, 2e-8, -1e-8, 3e-8, -2e-8, 1e-8}},
                   {"station_scale", "S1", {}, {2e-5}},
                   {"marker_shift", "T", {{"after_s", "10"}}, {1e-4, 2e-4, 3e-4}}};
  return robot;
}

ShotInput LoadedShot(int flange, RandomNumbers* random) {
  ShotInput shot(Eigen::VectorXd::Zero(6));
  for (double& q : shot.conditions.q) q = random->Uniform(-1.5, 1.5);
  shot.conditions.station = "S1";
  shot.conditions.has_time = shot.conditions.has_temperature = true;
  shot.conditions.time = 3600.0;
  shot.conditions.temperature = 2.5;
  shot.wrenches = {
      {flange, {0.28, 0.06, -0.15}, random->Vector(2000.0), random->Vector(100.0), WrenchFrame::kMeasurement}};
  shot.conditions.load_wrenches = shot.wrenches;
  return shot;
}

// log(R(x) R(0)'), the left perturbation between two predicted rotations.
Vector3<double> Turned(const Vector3<double>& to, const Vector3<double>& from) {
  return RotationVector(Matrix3<double>(RotationFromVector(to) * RotationFromVector(from).transpose()));
}

TEST(PoseReading, RotationIsTheProductOfTheTransforms) {
  const ForwardModel model(test::Kr270Chain());
  RandomNumbers random(3);
  std::vector<double> theta(model.num_parameters());
  for (double& value : theta) value = random.Uniform(-0.01, 0.01);
  ShotInput shot(Eigen::VectorXd::Zero(6));
  for (double& q : shot.conditions.q) q = random.Uniform(-1.5, 1.5);
  Pose<double> base;
  base.rotation = Eigen::AngleAxisd(0.7, Vector3<double>(1, 2, 3).normalized()).toRotationMatrix();
  base.translation = {1.0, 2.0, 3.0};
  MarkerInFrame target{model.chain().FlangeFrame(), {0.1, 0.2, 0.3}, 0, ReadingKind::kRotation};
  target.rotation = Eigen::AngleAxisd(-1.1, Vector3<double>(-1, 1, 0.5).normalized()).toRotationMatrix();
  std::vector<PointPrediction> prediction;
  ASSERT_TRUE(model.Predict(shot, theta.data(), {}, base, {target}, &prediction));
  const auto turn = [](int axis, double angle) -> Eigen::Matrix3d {
    return Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
  };
  // In the order of Kr270Chain; theta by the order of its named errors.
  const Eigen::VectorXd& q = shot.conditions.q;
  const Eigen::Matrix3d expected = base.rotation * turn(2, q[0]) * turn(0, theta[2]) * turn(1, q[1] + theta[3]) *
                                   turn(0, theta[5]) * turn(2, theta[6]) * turn(1, q[2] + theta[7]) *
                                   turn(2, theta[10]) * turn(0, q[3] + theta[11]) * turn(2, theta[14]) *
                                   turn(1, q[4] + theta[15]) * turn(2, theta[17]) * turn(0, q[5]) * target.rotation;
  EXPECT_LT((RotationFromVector(prediction[0].point) - expected).norm(), 1e-14);
}

TEST(PoseReading, DerivativesEqualDifferences) {
  const ForwardModel model(ArmWithEffects(), {"T"});
  const int n = model.num_parameters();
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  RandomNumbers random(17);
  const std::vector<double> still(6, 0.0);
  for (int pose = 0; pose < 4; ++pose) {
    ShotInput shot = LoadedShot(model.chain().FlangeFrame(), &random);
    model.Prepare(&shot);
    std::vector<double> theta = model.NominalValues();
    for (int i = 0; i < n; ++i) {
      if (model.parameters()[i].law == ParameterLaw::kGeometry) theta[i] = random.Uniform(-1e-2, 1e-2);
    }
    Pose<double> base;
    base.rotation = RotationFromVector<double>(random.Vector(1.0));
    base.translation = random.Vector(2.0);
    const int frame = pose % 2 == 0 ? model.chain().FlangeFrame() : model.chain().FrameAfterJoint(3);
    MarkerInFrame target{frame, random.Vector(0.3), 0, ReadingKind::kRotation,
                         RotationFromVector<double>(random.Vector(1.5))};
    std::vector<PointPrediction> here;
    ASSERT_TRUE(model.Predict(shot, theta.data(), all, base, {target}, &here, still.data()));
    const auto differences = [&](const auto& predict, double step) -> Vector3<double> {
      return test::RiddersDerivative([&](double x) -> Eigen::VectorXd { return Turned(predict(x), here[0].point); },
                                     0.0, step);
    };
    const auto predicted = [&](const std::vector<double>& at, const Pose<double>& from, const MarkerInFrame& marker,
                               const std::vector<double>& latent) {
      std::vector<PointPrediction> there;
      EXPECT_TRUE(model.Predict(shot, at.data(), {}, from, {marker}, &there, latent.data()));
      return there[0].point;
    };
    const auto expect = [&](const Vector3<double>& ours, const Vector3<double>& numeric, const std::string& what) {
      EXPECT_LE((ours - numeric).norm(), 1e-6 * std::max(numeric.norm(), 1e-3)) << what << " in pose " << pose;
    };
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3<double> unit = Vector3<double>::Unit(axis);
      expect(here[0].d_rotation.col(axis),
             differences(
                 [&](double x) {
                   Pose<double> moved = base;
                   moved.rotation = RotationFromVector(Vector3<double>(x * unit)) * base.rotation;
                   return predicted(theta, moved, target, still);
                 },
                 1e-3),
             "base rotation");
      expect(here[0].d_marker.col(axis),
             differences(
                 [&](double x) {
                   MarkerInFrame moved = target;
                   moved.rotation = RotationFromVector(Vector3<double>(x * unit)) * target.rotation;
                   return predicted(theta, base, moved, still);
                 },
                 1e-3),
             "target");
      EXPECT_TRUE(here[0].d_translation.col(axis).isZero(0.0));
    }
    for (int i = 0; i < n; ++i) {
      const ModelParameter& parameter = model.parameters()[i];
      const double step = std::max(1e-3 * std::abs(theta[i]), 1e-2 * TraitsOf(parameter.quantity).hold_limit);
      expect(here[0].d_theta.col(i),
             differences(
                 [&](double x) {
                   std::vector<double> moved = theta;
                   moved[i] += x;
                   return predicted(moved, base, target, still);
                 },
                 step),
             parameter.name);
    }
    for (int j = 0; j < 6; ++j) {
      expect(here[0].d_latent.col(j),
             differences(
                 [&](double x) {
                   std::vector<double> moved = still;
                   moved[j] += x;
                   return predicted(theta, base, target, moved);
                 },
                 1e-3),
             "deviation of joint " + std::to_string(j));
    }
  }
}

// What turns nothing: growth, scale, a shifted marker, a target that sits elsewhere.
TEST(PoseReading, WhatMovesPointsAloneTurnsNothing) {
  const ForwardModel model(ArmWithEffects(), {"T"});
  RandomNumbers random(5);
  ShotInput shot = LoadedShot(model.chain().FlangeFrame(), &random);
  model.Prepare(&shot);
  std::vector<int> all(model.num_parameters());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<double> theta = model.NominalValues();
  const MarkerInFrame target{model.chain().FlangeFrame(), random.Vector(0.3), 0, ReadingKind::kRotation};
  std::vector<PointPrediction> prediction;
  ASSERT_TRUE(model.Predict(shot, theta.data(), all, Pose<double>(), {target}, &prediction));
  int silent = 0;
  for (int i = 0; i < model.num_parameters(); ++i) {
    const std::string& name = model.parameters()[i].name;
    for (const char* family : {"effect/thermal_growth", "effect/station_scale", "effect/marker_shift"}) {
      if (name.rfind(family, 0) != 0) continue;
      EXPECT_TRUE(prediction[0].d_theta.col(i).isZero(0.0)) << name;
      ++silent;
    }
  }
  EXPECT_EQ(silent, 5);
}

TEST(Reading, MisfitIsTheLeftPerturbationFromMeasuredToPredicted) {
  TargetReading measured{ReadingKind::kRotation, {1, 2, 3}, RotationFromVector(Vector3<double>(0.4, -1.0, 0.3))};
  const Vector3<double> off(0.02, -0.01, 0.03);
  const Vector3<double> predicted = RotationVector(Matrix3<double>(RotationFromVector(off) * measured.rotation));
  EXPECT_LT((MeasuredMinusPredicted(measured, predicted) + off).norm(), 1e-14);
  measured.kind = ReadingKind::kPoint;
  EXPECT_EQ(MeasuredMinusPredicted(measured, {1, 2, 4}), Vector3<double>(0, 0, -1));
}

TEST(Reading, JacobiansOfTheExponentialEqualDifferences) {
  RandomNumbers random(8);
  for (const double size : {0.0, 1e-6, 1e-3, 0.5, 2.5}) {
    const Vector3<double> v = size * random.Vector(1.0).normalized();
    Matrix3<double> numeric;
    for (int axis = 0; axis < 3; ++axis) {
      numeric.col(axis) = test::RiddersDerivative(
          [&](double x) -> Eigen::VectorXd { return Turned(v + x * Vector3<double>::Unit(axis), v); }, 0.0, 1e-2);
    }
    EXPECT_LT((LeftJacobian(v) - numeric).norm(), 1e-9) << size;
    EXPECT_LT((InverseLeftJacobian(v) * LeftJacobian(v) - Matrix3<double>::Identity()).norm(), 1e-11) << size;
  }
}

}  // namespace
}  // namespace sagitta::pose_reading_test
