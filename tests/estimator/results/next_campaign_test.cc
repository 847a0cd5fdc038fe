// What a campaign's robot is for the next one: the same arm at every pose, at the reading its encoders have now.
#include "estimator/results/next_campaign.h"

#include <gtest/gtest.h>

#include "models/effects/catalogue.h"
#include "problems/io/robot_file.h"
#include "tests/support/loaded_kr270.h"

namespace sagitta::next_campaign_test {
namespace {

constexpr double kJump = 3e-4;  // rad

// Loaded and unloaded shots, an hour after the joint slipped.
Measurements Later() {
  Measurements data = test::LoadedRows(test::LoadedDesign(), test::Everything());
  for (Shot& shot : data.shots) shot.has_time = true, shot.time = 3600.0 + 10.0 * shot.configuration;
  data.shots[0].time = 0.0;  // the campaign's first
  return data;
}

EffectSpec SlipOf(const std::string& joint) {
  EffectSpec slip{"joint_slip", joint, {{"after_s", "600"}}, {}};
  slip.values = {kJump};
  return slip;
}

test::LoadedSetup ArmSetup() {
  test::LoadedSetup setup = test::SetupFor(test::Everything());
  const test::SpringTruth spring = *test::Everything().spring;
  setup.robot.gravity_compensator =
      GravityCompensator{1, spring.L, spring.a_x, spring.a_y, spring.s0, spring.Kc, true, {}};
  for (int j = 0; j < 6; ++j) setup.robot.compliances.push_back({j, {{0.0, 4e-7}}, false});
  return setup;
}

// Of all shots but the first, m.
Eigen::Matrix3Xd PointsOf(const Robot& robot, const test::LoadedSetup& setup) {
  const Measurements data = Later();
  const CalibrationProblem problem = MakeKnownProblem(robot, data, setup.experiment, {});
  std::vector<int> rows;
  for (size_t i = 0; i < data.observations.size(); ++i) {
    if (data.observations[i].shot > 0) rows.push_back(static_cast<int>(i));
  }
  return PredictPoints(problem, problem.parameters, rows);
}

TEST(NextCampaign, AJointThatSlippedHasItsZeroWhereItWent) {
  const test::LoadedSetup setup = ArmSetup();
  for (const std::string joint : {"A2", "A3"}) {  // the compensator acts on A2
    Robot extended = setup.robot;
    extended.effects = {SlipOf(joint)};
    const std::optional<Robot> next = RobotOfTheNextCampaign(extended);
    ASSERT_TRUE(next.has_value());
    EXPECT_TRUE(next->effects.empty());
    const Eigen::Matrix3Xd slipped = PointsOf(extended, setup);
    EXPECT_LT((PointsOf(*next, setup) - slipped).cwiseAbs().maxCoeff(), 1e-12) << joint;
    EXPECT_GT((PointsOf(setup.robot, setup) - slipped).cwiseAbs().maxCoeff(), 1e-4) << joint;
  }
}

// Two tables: theta of a joint that turns, d of one that slides.
TEST(NextCampaign, ATableCarriesIt) {
  const std::string text = R"(
schema: sagitta/robot/1
joints: [{name: A1, type: revolute}, {name: A2, type: prismatic}]
kinematics:
  dh: {convention: standard, links: [
    {joint: A1, a_mm: 300, alpha_deg: 90, d_mm: 400, theta_deg: 10},
    {joint: A2, a_mm: 0, alpha_deg: 0, d_mm: 50, theta_deg: 0}]}
effects:
  - {effect: joint_slip, joint: A1, after_s: 600, jump_urad: 300}
  - {effect: joint_slip, joint: A2, after_s: 600, jump_um: 70}
)";
  const std::optional<Robot> next = RobotOfTheNextCampaign(ReadRobotText(text, "robot.yaml"));
  ASSERT_TRUE(next.has_value());
  const Robot again = ReadRobotText(RobotToYaml(*next), "robot.yaml");
  ASSERT_TRUE(again.dh.has_value());
  EXPECT_NEAR(again.dh->links[0].theta, 10.0 * kDegree + 300e-6, 1e-12);
  EXPECT_NEAR(again.dh->links[1].d, 0.05 + 70e-6, 1e-12);
  EXPECT_NEAR(again.chain.transforms[again.chain.JointTransform(0)].nominal,
              next->chain.transforms[next->chain.JointTransform(0)].nominal, 1e-12);
}

TEST(NextCampaign, WhatGoesWithOtherThingsStays) {
  Robot extended = ArmSetup().robot;
  EXPECT_FALSE(RobotOfTheNextCampaign(extended).has_value());
  extended.effects = {{"encoder_gain", "A3", {}, {}}};
  EXPECT_FALSE(RobotOfTheNextCampaign(extended).has_value());
  extended.effects.push_back({"station_drift", "S1", {}, {}});
  const std::optional<Robot> next = RobotOfTheNextCampaign(extended);
  ASSERT_TRUE(next.has_value());
  ASSERT_EQ(next->effects.size(), 1u);
  EXPECT_EQ(next->effects[0].effect, "encoder_gain");
}

}  // namespace
}  // namespace sagitta::next_campaign_test
