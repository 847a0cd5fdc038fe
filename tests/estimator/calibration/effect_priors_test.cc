// Priors that a robot file states of its effects' parameters: against the closed form of one prior, whatever noise is
// stated.
#include "estimator/calibration/effect_priors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/calibration/joint_estimator.h"
#include "tests/support/dh_campaigns.h"

namespace sagitta::effect_priors_test {
namespace {

constexpr double kAmplitude = 60e-6;  // rad, true

// Joint 3 turns by a cos(3 q) more than is commanded. prior: of a, rad; stated: sigma of the rows, in true ones.
CalibrationProblem WithPrior(double prior, double stated) {
  test::DhCampaign campaign;
  Measurements data = test::MeasurementsOf(campaign);
  for (Configuration& configuration : data.configurations)
    configuration.q[2] -= kAmplitude * std::cos(3.0 * configuration.q[2]);
  for (Observation& row : data.observations) row.sigma *= stated;
  Robot robot = test::ProblemOf(campaign).robot();
  robot.effects = {{"joint_harmonic", robot.chain.joints[2].name, {{"order", "3"}}, {}, {prior, 0.0}}};
  if (!(prior > 0.0)) robot.effects[0].prior_sigmas.clear();
  return MakeCalibrationProblem(robot, data, Experiment());
}

ParameterEstimate CosOf(double prior, double stated) {
  const CalibrationProblem problem = WithPrior(prior, stated);
  const Estimate estimate = EstimateJointly(problem, JointOptions());
  EXPECT_TRUE(IsUsable(estimate.status)) << estimate.message;
  return estimate.table[estimate.parameters.Match("effect")[0]];
}

// With v0 and s0 without a prior, s0 by the scatter of the rows:  v = v0 P^2 / (P^2 + s0^2), s^2 = s0^2 P^2 / (P^2 +
// s0^2). Where sigma is stated too large the interval is that of the stated one, the value is not.
TEST(EffectPriors, WeighAsMuchWhateverNoiseIsStated) {
  const ParameterEstimate without = CosOf(0.0, 0.1);
  ASSERT_NEAR(without.value, kAmplitude, 5.0 * without.sigma);
  const double prior = without.sigma;
  for (const double stated : {0.1, 1.0, 10.0}) {
    const ParameterEstimate with = CosOf(prior, stated);
    EXPECT_NEAR(with.value, 0.5 * without.value, 0.05 * without.value) << stated;
  }
  EXPECT_NEAR(CosOf(prior, 0.1).sigma, std::sqrt(0.5) * without.sigma, 0.05 * without.sigma);
}

// What no row sees stays within its prior and is not held.
TEST(EffectPriors, HoldNothing) {
  CalibrationProblem problem = WithPrior(1e-4, 1.0);
  for (Configuration& configuration : problem.mutable_data()->configurations) configuration.q[2] = 0.4;
  problem = MakeCalibrationProblem(problem.robot(), problem.data(), Experiment());
  const Estimate estimate = EstimateJointly(problem, JointOptions());
  const int cos = estimate.parameters.Match("effect")[0];
  EXPECT_TRUE(estimate.parameters.coordinates()[cos].estimated());
  EXPECT_TRUE(estimate.parameters.coordinates()[cos + 1].held);  // has none
}

TEST(EffectPriors, TheWrittenRobotHasThem) {
  const CalibrationProblem problem = WithPrior(1e-4, 1.0);
  const Robot robot = problem.RobotWith(problem.parameters);
  ASSERT_EQ(robot.effects[0].prior_sigmas.size(), 2u);
  EXPECT_DOUBLE_EQ(robot.effects[0].prior_sigmas[0], 1e-4);
  EXPECT_EQ(robot.effects[0].prior_sigmas[1], 0.0);
  const CalibrationProblem without = WithPrior(0.0, 1.0);
  EXPECT_TRUE(without.RobotWith(without.parameters).effects[0].prior_sigmas.empty());
}

TEST(EffectPriors, AreScaledUntilTheyStandStill) {
  ParameterSet parameters = WithPrior(1e-4, 1.0).parameters;
  const int cos = parameters.Match("effect")[0];
  EXPECT_TRUE(AnyEffectPrior(parameters));
  EXPECT_TRUE(ScaleEffectPriors(4.0, &parameters));
  EXPECT_DOUBLE_EQ(parameters.coordinates()[cos].prior_sigma, 2.5e-5);
  EXPECT_FALSE(ScaleEffectPriors(4.1, &parameters));
  EXPECT_EQ(parameters.coordinates()[cos + 1].prior_sigma, 0.0);
  EXPECT_FALSE(AnyEffectPrior(WithPrior(0.0, 1.0).parameters));
}

}  // namespace
}  // namespace sagitta::effect_priors_test
