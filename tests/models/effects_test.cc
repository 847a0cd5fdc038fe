// Every effect of the catalogue against the contract, and what the catalogue says.
#include <gtest/gtest.h>

#include <numeric>

#include "models/effects/catalogue.h"
#include "tests/support/effect_contract.h"

namespace sagitta::effects_test {
namespace {

std::vector<EffectSpec> Uses() { return test::ContractUses(EffectCatalogue()); }

class EffectContract : public ::testing::TestWithParam<int> {};

TEST_P(EffectContract, NeutralExactAndVisible) { test::ExpectEffectContract(Uses()[GetParam()], 11 + GetParam()); }

TEST_P(EffectContract, SaysThatItGoesWithTime) { test::ExpectTimeIsStated(Uses()[GetParam()], 31 + GetParam()); }

INSTANTIATE_TEST_SUITE_P(Catalogue, EffectContract, ::testing::Range(0, static_cast<int>(Uses().size())));

TEST(EffectCatalogue, HasEveryEffectOfTheFormat) {
  const std::vector<std::string> expected = {"frozen_geometry",
                                             "joint_compliance",
                                             "compliance_hardening",
                                             "transverse_compliance",
                                             "link_gravity",
                                             "self_weight_sag",
                                             "base_compliance",
                                             "payload",
                                             "joint_harmonic",
                                             "axis_wobble",
                                             "encoder_gain",
                                             "joint_coupling",
                                             "backlash",
                                             "joint_slip",
                                             "thermal_growth",
                                             "station_drift",
                                             "station_scale",
                                             "marker_shift",
                                             "warm_up",
                                             "station_eccentricity",
                                             "station_range_offset",
                                             "load_com",
                                             "hysteresis",
                                             "marker_acceptance",
                                             "station_refraction",
                                             "learnt_deviation",
                                             "learnt_wave_deviation",
                                             "learnt_jump_deviation",
                                             "learnt_pair_deviation",
                                             "learnt_product_deviation",
                                             "learnt_surface_deviation",
                                             "learnt_growth",
                                             "learnt_station_motion",
                                             "learnt_station_wave",
                                             "learnt_marker_motion",
                                             "learnt_marker_seat",
                                             "learnt_tool_motion",
                                             "learnt_station_field",
                                             "learnt_load_shift",
                                             "learnt_load_slide",
                                             "learnt_pull",
                                             "learnt_lag",
                                             "learnt_reading",
                                             "learnt_range_wave"};
  EXPECT_EQ(EffectNames(), expected);
}

TEST(EffectCatalogue, SaysInWordsWhatItIsAndWhatTellsItApart) {
  for (const EffectDefinition* effect : EffectCatalogue()) {
    EXPECT_FALSE(effect->title.empty() || effect->reference.empty() || effect->separate_by.empty()) << effect->name;
    EXPECT_FALSE(effect->sizes.empty()) << effect->name << " says where its typical sizes are from";
    if (effect->target == EffectTarget::kJoint) continue;
    EXPECT_EQ(effect->separate_by.find("{target}"), std::string::npos) << effect->name << " has no joint to speak of";
  }
}

TEST(EffectCatalogue, StatesATypicalSizeOfEveryParameter) {
  const Robot robot = test::ContractArm();
  for (const EffectSpec& use : Uses()) {
    for (const EffectParameter& parameter : FindEffect(use.effect)->parameters(robot, use)) {
      EXPECT_GT(parameter.typical, 0.0) << use.Path() << " " << parameter.name;
    }
  }
}

TEST(EffectCatalogue, SaysWhichColumnIsMissing) {
  const Robot robot = test::ContractArm();
  ShotConditions nothing;
  nothing.q = Eigen::VectorXd::Zero(6);
  EffectSpec spec{"backlash", "A3", {{"by", "approach"}}, {}};
  EXPECT_EQ(MissingColumn(*FindEffect("backlash"), {&robot, &spec, &nothing, &test::ContractMarkers(), 0}),
            "approach3");
  spec = {"thermal_growth", "robot", {}, {}};
  EXPECT_EQ(MissingColumn(*FindEffect("thermal_growth"), {&robot, &spec, &nothing, &test::ContractMarkers(), 0}),
            "temperature_degC");
}

// One definition, driven by what a use of it says.
TEST(EffectCatalogue, AsksTheUseWhatDrivesIt) {
  const Robot robot = test::ContractArm();
  ShotConditions nothing;
  nothing.q = Eigen::VectorXd::Zero(6);
  EffectSpec spec{"learnt_deviation", "A3", {{"by", "time_s"}, {"from", "0"}, {"to", "100"}, {"knots", "2"}}, {}};
  const EffectDefinition& definition = *FindEffect(robot, spec.effect);
  EXPECT_TRUE(GoesWithTime(robot, spec));
  EXPECT_EQ(MissingColumn(definition, {&robot, &spec, &nothing, &test::ContractMarkers(), 0}), "time_s");
  spec.settings["by"] = "temperature_K";
  EXPECT_EQ(definition.DrivenBy(spec), EffectDriver::kTemperature);
  EXPECT_EQ(MissingColumn(definition, {&robot, &spec, &nothing, &test::ContractMarkers(), 0}), "temperature_degC");
  spec.settings["by"] = "q";
  EXPECT_EQ(definition.DrivenBy(spec), EffectDriver::kJoint);
  EXPECT_EQ(MissingColumn(definition, {&robot, &spec, &nothing, &test::ContractMarkers(), 0}), "");
}

TEST(EffectCatalogue, FindsTheEffectOfAName) {
  EXPECT_EQ(EffectOfName("effect/payload/L1/dmass"), &Payload());
  EXPECT_EQ(EffectOfName("effect/joint_harmonic[order=2]/A3/cos"), &JointHarmonic());
  EXPECT_EQ(EffectOfName("effect/payload"), &Payload());
  EXPECT_EQ(EffectOfName("payload/L1/dmass"), nullptr);
  EXPECT_EQ(EffectOfName("effect/of_nobody/A3/x"), nullptr);
  EXPECT_EQ(EffectOfName("geometry/A2.theta"), nullptr);
  EXPECT_TRUE(IsUseOf(LoadCom(), {"load_com", "L1", {}, {}}));
  EXPECT_FALSE(IsUseOf(LoadCom(), {"payload", "L1", {}, {}}));
}

// A monument on the floor and a point on the foot stand still while the arm grows by 100 ppm.
TEST(ThermalGrowth, IsThatOfTheArmAlone) {
  Robot robot = test::ContractArm();
  robot.effects = {{"thermal_growth", "robot", {}, {}}};
  const ForwardModel model(robot);
  std::vector<double> theta(model.num_parameters(), 0.0);
  std::vector<int> all(theta.size());
  std::iota(all.begin(), all.end(), 0);
  theta.back() = 1e-5;  // 1/K
  ShotInput shot(Eigen::VectorXd::Constant(6, 0.3));
  shot.conditions.has_temperature = true;
  ShotInput warm = shot;
  warm.conditions.temperature = 10.0;
  const Vector3<double> point(0.4, -0.3, 0.2);
  const std::vector<MarkerInFrame> markers = {
      {model.chain().WorldFrame(), point}, {model.chain().BaseFrame(), point}, {model.chain().FlangeFrame(), point}};
  std::vector<PointPrediction> cold_points, warm_points;
  ASSERT_TRUE(model.Predict(shot, theta.data(), all, Pose<double>(), markers, &cold_points));
  ASSERT_TRUE(model.Predict(warm, theta.data(), all, Pose<double>(), markers, &warm_points));
  for (size_t m = 0; m < markers.size(); ++m) {
    const double factor = m == 2 ? 1e-4 : 0.0;
    const Vector3<double> grown = warm_points[m].point - cold_points[m].point;
    EXPECT_LT((grown - factor * cold_points[m].point).norm(), 1e-12) << m;
    const Vector3<double> by_growth = m == 2 ? Vector3<double>(10.0 * cold_points[m].point) : Vector3<double>::Zero();
    EXPECT_LT((warm_points[m].d_theta.rightCols(1) - by_growth).norm(), 1e-9) << m;
    const Vector3<double> reference = model.PointInStation<double>(
        warm, theta.data(), markers[m], point, Matrix3<double>::Identity(), Vector3<double>::Zero());
    EXPECT_LT((reference - warm_points[m].point).norm(), 1e-12) << m;
  }
}

}  // namespace
}  // namespace sagitta::effects_test
