// Every effect of the catalogue against the contract, and what the catalogue says.
#include "models/effects/catalogue.h"

#include <gtest/gtest.h>

#include "tests/support/effect_contract.h"

namespace sagitta {
namespace {

std::vector<EffectSpec> Uses() { return test::ContractUses(EffectCatalogue()); }

class EffectContract : public ::testing::TestWithParam<int> {};

TEST_P(EffectContract, NeutralExactAndVisible) { test::ExpectEffectContract(Uses()[GetParam()], 11 + GetParam()); }

INSTANTIATE_TEST_SUITE_P(Catalogue, EffectContract, ::testing::Range(0, static_cast<int>(Uses().size())));

TEST(EffectCatalogue, HasEveryEffectOfTheFormat) {
  const std::vector<std::string> expected = {
      "frozen_geometry", "joint_compliance", "compliance_hardening", "transverse_compliance",
      "link_gravity",    "self_weight_sag",  "base_compliance",      "payload",
      "joint_harmonic",  "axis_wobble",      "encoder_gain",         "joint_coupling",
      "backlash",        "joint_slip",       "thermal_growth",       "station_drift",
      "station_scale",   "marker_shift"};
  EXPECT_EQ(EffectNames(), expected);
}

TEST(EffectCatalogue, SaysInWordsWhatItIsAndWhatTellsItApart) {
  for (const EffectDefinition* effect : EffectCatalogue()) {
    EXPECT_FALSE(effect->title.empty() || effect->reference.empty() || effect->separate_by.empty()) << effect->name;
    if (effect->target == EffectTarget::kJoint) continue;
    EXPECT_EQ(effect->separate_by.find("{target}"), std::string::npos) << effect->name << " has no joint to speak of";
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

}  // namespace
}  // namespace sagitta
