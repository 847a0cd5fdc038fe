// The contract of an effect, for those of the catalogue and for one's own: neutral
// at zero, exact derivatives at neutral, at 1e-8 of a typical size and at that
// size, every parameter visible.
#pragma once

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <set>

#include "models/effects/catalogue.h"
#include "models/forward_model.h"
#include "tests/support/kr270.h"

namespace sagitta::test {

constexpr int kMostContractUnknowns = 112;
using ContractJet = ceres::Jet<double, kMostContractUnknowns>;

inline const std::vector<std::string>& ContractMarkers() {
  static const std::vector<std::string> markers = {"M1", "M2"};
  return markers;
}

// A loaded arm whose joints all give way.
inline Robot ContractArm() {
  Robot robot;
  robot.chain = Kr270Chain();
  for (Joint& joint : robot.chain.joints) joint.min = -2.0, joint.max = 2.5;
  const double k[6] = {0.623e-6, 0.287e-6, 0.416e-6, 2.786e-6, 3.483e-6, 2.074e-6};
  for (int j = 0; j < 6; ++j) robot.compliances.push_back({j, {{0.0, k[j]}}, false});
  return robot;
}

// One use of each definition with a setting of every kind, on what ContractShot has.
inline std::vector<EffectSpec> ContractUses(const std::vector<const EffectDefinition*>& definitions) {
  std::vector<EffectSpec> uses;
  for (const EffectDefinition* definition : definitions) {
    EffectSpec spec;
    spec.effect = definition->name;
    switch (definition->target) {
      case EffectTarget::kJoint:
        spec.target = "A3";
        break;
      case EffectTarget::kError:
        spec.target = "phi_z2";
        break;
      case EffectTarget::kBase:
        spec.target = "base";
        break;
      case EffectTarget::kRobot:
        spec.target = "robot";
        break;
      case EffectTarget::kStation:
        spec.target = "S1";
        break;
      case EffectTarget::kLoad:
        spec.target = "heavy";
        break;
      case EffectTarget::kMarker:
        spec.target = "M2";
        break;
    }
    std::vector<EffectSpec> variants = {spec};
    for (const SettingDefinition& setting : definition->settings) {
      const std::vector<EffectSpec> before = std::move(variants);
      variants.clear();
      std::vector<std::string> texts = setting.choices;
      if (setting.kind == SettingDefinition::Kind::kInteger)
        texts = {std::to_string(setting.least), std::to_string(std::min(3, setting.most))};
      if (setting.kind == SettingDefinition::Kind::kNumber) texts = {setting.choices.empty() ? "100" : texts.back()};
      if (setting.name == "unit") texts = {"1"};  // of what a joint follows late: N m, m or deg/s
      // Seen by every driver of ContractShot; of two joints their range.
      const std::string reach = spec.effect == "learnt_product_deviation" ? "180" : "9000";
      if (setting.name.rfind("from", 0) == 0) texts = {"-" + reach};
      if (setting.name.rfind("to", 0) == 0) texts = {reach};
      if (setting.kind == SettingDefinition::Kind::kMoment) texts = {"100"};
      if (setting.kind == SettingDefinition::Kind::kJoint) texts = {setting.name == "with" ? "A4" : "A2"};
      for (EffectSpec variant : before) {
        if (setting.silent) variants.push_back(variant);
        if (!setting.MeansSomethingFor(variant)) continue;
        for (const std::string& text : texts) {
          variant.settings[setting.name] = text;
          variants.push_back(variant);
        }
      }
    }
    uses.insert(uses.end(), variants.begin(), variants.end());
  }
  return uses;
}

inline ShotInput ContractShot(int flange, RandomNumbers* random) {
  ShotInput shot(Eigen::VectorXd::Zero(6));
  for (int j = 0; j < 6; ++j) shot.conditions.q[j] = random->Uniform(-1.5, 1.5);
  shot.conditions.station = "S1";
  shot.conditions.load = "heavy";
  shot.conditions.has_time = shot.conditions.has_temperature = true;
  shot.conditions.time = 7200.0;
  shot.conditions.station_time = 3600.0;
  shot.conditions.temperature = 2.5;
  shot.conditions.approach = {1, -1, 1, -1, 1, -1};
  shot.conditions.instrument = {6.0, -4.0, 2.0};
  shot.wrenches = {
      {flange, {0.28, 0.06, -0.15}, random->Vector(2000.0), random->Vector(100.0), WrenchFrame::kMeasurement}};
  shot.conditions.load_wrenches = shot.wrenches;
  return shot;
}

// By the parameter's full name; where the definition states none, a size at which the effect is about 0.1 to 1 mm at
// the flange of a large arm.
inline std::map<std::string, double> TypicalSizes(const Robot& robot, const EffectSpec& use) {
  std::map<std::string, double> sizes;
  for (const EffectParameter& parameter : FindEffect(robot, use.effect)->parameters(robot, use)) {
    const double general = TraitsOf(parameter.quantity).hold_limit * 0.1;
    sizes[use.Path() + "/" + parameter.name] =
        parameter.typical > 0.0 && !parameter.of_motion ? parameter.typical : general;
  }
  return sizes;
}

inline void ExpectEffectContract(const EffectSpec& use, int seed,
                                 const std::vector<const EffectDefinition*>& own_effects = {}) {
  Robot robot = ContractArm();
  robot.own_effects = own_effects;
  robot.effects = {use};
  const ForwardModel model(robot, ContractMarkers());
  const ForwardModel without(ContractArm(), ContractMarkers());
  const int n = model.num_parameters();
  ASSERT_LE(n + 3, kMostContractUnknowns);
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  RandomNumbers random(seed);
  std::map<std::string, double> typical = TypicalSizes(robot, use);
  std::set<int> visible;
  double largest = 0.0;  // m
  for (const double size : {0.0, 1e-8, 1.0}) {
    for (int pose = 0; pose < 6; ++pose) {
      ShotInput shot = ContractShot(model.chain().FlangeFrame(), &random);
      ShotInput plain = shot;
      plain.wrenches[0].frame = without.chain().FlangeFrame();
      // What remembers has something to remember: the arm came from elsewhere.
      std::vector<ShotInput> campaign = {shot, shot};
      campaign[0].conditions.q.setConstant(1.6);
      campaign[0].conditions.time = 3600.0;
      campaign[0].conditions.station_time = 0.0;
      campaign[0].conditions.temperature = 3.0;
      model.Prepare(&campaign);
      shot = campaign[1];
      without.Prepare(&plain);
      std::vector<double> theta = model.NominalValues();
      for (int i = 0; i < n; ++i) {
        if (model.parameters()[i].law == ParameterLaw::kGeometry) theta[i] = random.Uniform(-1e-3, 1e-3);
        if (model.parameters()[i].law == ParameterLaw::kEffect) {
          theta[i] = size * random.Uniform(0.5, 1.0) * typical[model.parameters()[i].name];
        }
      }
      Pose<double> base;
      base.rotation = RotationFromVector<double>(random.Vector(1.0));
      base.translation = random.Vector(2.0);
      const MarkerInFrame marker{model.chain().FlangeFrame(), random.Vector(0.3), 1};
      std::vector<PointPrediction> prediction, reference;
      ASSERT_TRUE(model.Predict(shot, theta.data(), all, base, {marker}, &prediction));
      const MarkerInFrame same{without.chain().FlangeFrame(), marker.point, 1};
      ASSERT_TRUE(without.Predict(plain, theta.data(), {}, base, {same}, &reference));
      const double shift = (prediction[0].point - reference[0].point).norm();
      if (size == 0.0) {
        EXPECT_LT(shift, 1e-12) << use.Path();
      }
      if (size == 1.0) largest = std::max(largest, shift);

      Vector3<ContractJet> delta;
      std::vector<ContractJet> jets;
      for (int i = 0; i < 3; ++i) delta[i] = ContractJet(0.0, i);
      for (int i = 0; i < n; ++i) jets.emplace_back(theta[i], 3 + i);
      const Matrix3<ContractJet> rotation = RotationFromVector(delta) * base.rotation.cast<ContractJet>();
      const Vector3<ContractJet> expected =
          model.PointInStation(shot, jets.data(), marker, Vector3<ContractJet>(marker.point.cast<ContractJet>()),
                               rotation, Vector3<ContractJet>(base.translation.cast<ContractJet>()));
      const auto column = [&](int i) { return Vector3<double>(expected[0].v[i], expected[1].v[i], expected[2].v[i]); };
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(prediction[0].point[i], expected[i].a, 1e-11) << use.Path();
      for (int i = 0; i < 3; ++i) {
        EXPECT_LT((prediction[0].d_rotation.col(i) - column(i)).norm(), 1e-9) << use.Path();
      }
      for (int i = 0; i < n; ++i) {
        const Vector3<double> ours = prediction[0].d_theta.col(i);
        EXPECT_LE((ours - column(3 + i)).norm(), 1e-9 * std::max(column(3 + i).norm(), 1e-3))
            << use.Path() << " " << model.parameters()[i].name;
        if (model.parameters()[i].law == ParameterLaw::kEffect && ours.norm() > 0.0) visible.insert(i);
      }
    }
  }
  EXPECT_GT(largest, 1e-5) << use.Path();
  for (int i = 0; i < n; ++i) {
    if (model.parameters()[i].law == ParameterLaw::kEffect) {
      EXPECT_EQ(visible.count(i), 1u) << model.parameters()[i].name;
    }
  }
}

// What moves when all clocks are set is driven by time: predictions beyond the times of a calibration are warned of by
// that, and the next campaign leaves it out.
inline void ExpectTimeIsStated(const EffectSpec& use, int seed) {
  Robot robot = ContractArm();
  robot.effects = {use};
  const ForwardModel model(robot, ContractMarkers());
  std::map<std::string, double> typical = TypicalSizes(robot, use);
  std::vector<double> theta = model.NominalValues();
  for (int i = 0; i < model.num_parameters(); ++i) {
    if (model.parameters()[i].law == ParameterLaw::kEffect) theta[i] = typical[model.parameters()[i].name];
  }
  RandomNumbers random(seed);
  const ShotInput shot = ContractShot(model.chain().FlangeFrame(), &random);
  const MarkerInFrame marker{model.chain().FlangeFrame(), random.Vector(0.3), 1};
  const auto point_later_by = [&](double seconds) {
    std::vector<ShotInput> campaign = {shot, shot};
    campaign[0].conditions.q.setConstant(1.6);
    campaign[0].conditions.time -= 3600.0;
    campaign[0].conditions.station_time -= 3600.0;
    for (ShotInput& each : campaign) {
      each.conditions.time += seconds;
      each.conditions.station_time += seconds;
    }
    model.Prepare(&campaign);
    std::vector<PointPrediction> prediction;
    EXPECT_TRUE(model.Predict(campaign[1], theta.data(), {}, {}, {marker}, &prediction)) << use.Path();
    return prediction[0].point;
  };
  const Vector3<double> now = point_later_by(0.0);
  for (const double seconds : {1700.0, -7150.0}) {  // the second: before what the contract's moment is
    if ((point_later_by(seconds) - now).norm() < 1e-9) continue;
    EXPECT_EQ(FindEffect(robot, use.effect)->DrivenBy(use), EffectDriver::kTime) << use.Path();
  }
}

}  // namespace sagitta::test
