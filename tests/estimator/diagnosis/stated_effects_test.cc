// Effects of the robot file whose values are believed, and what is found in their place.
#include "estimator/diagnosis/stated_effects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/moved_kr270.h"

namespace sagitta::stated_effects_test {
namespace {

// The robot file states a wave of A3, whose amplitudes are believed to be 0; joint `moved` has one of 150 urad.
DiagnosedModel Believed(int moved) {
  const Measurements data = test::MeasuredAfter(test::CampaignOf(50, 1, 2e-5, 3), 103, [moved](Eigen::VectorXd* q) {
    (*q)[moved] += 150e-6 * std::cos((*q)[moved]);
  });
  Robot robot = test::Kr270Robot();
  robot.effects = {{"joint_harmonic", "A3", {{"order", "1"}}, {0.0, 0.0}}};
  Experiment experiment;
  experiment.estimate.effects.kind = Selection::Kind::kNone;
  return FitFully(MakeCalibrationProblem(robot, data, experiment), JointOptions());
}

Candidate WaveOf(const std::string& joint) { return {{"joint_harmonic", joint, {{"order", "1"}}, {}}}; }

TEST(StatedEffects, OneThatExplainsAsMuchIsNamed) {
  const DiagnosedModel believed = Believed(2);
  ASSERT_EQ(HeldEffects(*believed.problem).size(), 1u);
  const std::vector<EffectSpec> instead = StatedInPlaceOf(believed, {WaveOf("A2")}, 0, JointOptions());
  ASSERT_EQ(instead.size(), 1u);
  EXPECT_EQ(instead[0].target, "A3");
}

TEST(StatedEffects, OneThatExplainsLessIsNot) {
  const DiagnosedModel believed = Believed(1);
  EXPECT_TRUE(StatedInPlaceOf(believed, {WaveOf("A2")}, 0, JointOptions()).empty());
  const Candidate gain{{"encoder_gain", "A2", {}, {}}};  // of another kind
  EXPECT_TRUE(StatedInPlaceOf(Believed(2), {gain}, 0, JointOptions()).empty());
}

}  // namespace
}  // namespace sagitta::stated_effects_test
