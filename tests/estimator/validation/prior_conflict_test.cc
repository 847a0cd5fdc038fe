// Priors that the rows contradict: named, and no noise of the rows.
#include "estimator/validation/prior_conflict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/validation/trust.h"
#include "tests/support/judged.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::prior_conflict_test {
namespace {

using test::Kr270Design;
using ::testing::HasSubstr;
using ::testing::Not;

CalibrationProblem Problem(const Kr270Design& design, const Experiment& experiment = {}) {
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 100 + design.seed, &data);
  return test::Kr270ProblemOf(data, experiment);
}

Kr270Design Design(int configurations) {
  Kr270Design design;
  design.configurations = configurations;
  design.seed = 1;
  return design;
}

Trust TrustOf(const CalibrationProblem& problem) {
  Estimate estimate = EstimateJointly(problem);
  return test::JudgeTrust(problem, 1, &estimate);
}

// A gear that errs by 300 urad twice per turn, of which the robot file says that it does by 1 urad.
TEST(Trust, AnEffectSizeThatTheRowsContradictIsNamed) {
  const Kr270Design design = Design(40);
  Measurements data = test::DesignMeasurements(design);
  test::MeasureKr270(test::Kr270Truth(), design.sigma, 101, &data);
  for (Configuration& pose : data.configurations) pose.q[0] -= 3e-4 * std::sin(2.0 * pose.q[0]);
  const auto with = [&](double prior_sigma) {
    Robot robot;
    robot.chain = test::Kr270Chain();
    robot.effects = {{"joint_harmonic", "A1", {{"order", "2"}}, {0.0, 0.0}, {0.0, prior_sigma}}};
    return MakeCalibrationProblem(robot, data, Experiment());
  };
  const CalibrationProblem contradicted = with(1e-6);
  const std::vector<PriorConflict> conflicts = PriorsAgainstRows(contradicted, EstimateJointly(contradicted));
  ASSERT_EQ(conflicts.size(), 1U);
  EXPECT_DOUBLE_EQ(conflicts[0].prior_sigma, 1e-6);
  EXPECT_NEAR(conflicts[0].rows, 3e-4, 5.0 * conflicts[0].rows_sigma);
  EXPECT_THAT(TrustOf(contradicted).verdict.reasons,
              ::testing::Contains(HasSubstr("contradict the prior of effect/joint_harmonic[order=2]/A1/sin")));
  const CalibrationProblem wide = with(3e-4);
  EXPECT_TRUE(PriorsAgainstRows(wide, EstimateJointly(wide)).empty());
}

// Against the fit without the prior: x1 of variance d there, the prior x0 of variance p;  (x1 - x0) / sqrt(p + d).
TEST(Trust, APriorThatTheRowsContradictIsNamed) {
  const Kr270Design design = Design(40);
  const Estimate without = EstimateJointly(Problem(design));
  const std::string name = "geometry/p_x2";
  const auto row = std::find_if(without.table.begin(), without.table.end(),
                                [&](const ParameterEstimate& each) { return each.name == name; });
  ASSERT_NE(row, without.table.end());
  const auto with = [&](double off_mm, double sigma_mm) {
    Experiment experiment;
    experiment.priors[name] = {1e3 * row->value + off_mm, sigma_mm};
    return Problem(design, experiment);
  };
  const CalibrationProblem contradicted = with(3.0, 0.03);
  const Estimate estimate = EstimateJointly(contradicted);
  const std::vector<PriorConflict> conflicts = PriorsAgainstRows(contradicted, estimate);
  ASSERT_EQ(conflicts.size(), 1U);
  EXPECT_EQ(estimate.parameters.coordinates()[conflicts[0].coordinate].name, name);
  EXPECT_NEAR(conflicts[0].rows, row->value, 0.05 * row->sigma);  // the model bends by that much over 3 mm
  const double noise = conflicts[0].rows_sigma;
  EXPECT_NEAR(noise, row->sigma, 0.05 * row->sigma);  // the prior's misfit is not theirs
  EXPECT_NEAR(conflicts[0].sigmas, 3e-3 / std::hypot(3e-5, noise), 0.01 * conflicts[0].sigmas);
  EXPECT_THAT(TrustOf(contradicted).verdict.reasons, ::testing::Contains(HasSubstr("contradict the prior of " + name)));
  EXPECT_TRUE(PriorsAgainstRows(with(0.03, 0.03), EstimateJointly(with(0.03, 0.03))).empty());
}

// The least chi-square of rows and priors is that of the rows alone and the pull; a prior that is wrong scales nothing.
TEST(Trust, ThePullOfAWrongPriorIsNotTheNoiseOfTheRows) {
  const Kr270Design design = Design(40);
  const Estimate without = EstimateJointly(Problem(design));
  const std::string name = "geometry/p_x2";
  const int i = without.parameters.FindCoordinate(name);
  const auto with = [&](double off_mm) {
    Experiment experiment;
    experiment.priors[name] = {1e3 * without.table[i].value + off_mm, 0.03};
    return Problem(design, experiment);
  };
  const CalibrationProblem contradicted = with(3.0);
  const Estimate wrong = EstimateJointly(contradicted), right = EstimateJointly(with(0.03));
  EXPECT_TRUE(wrong.sigma.pull.is_set_aside);
  EXPECT_EQ(wrong.sigma.pull.priors, 1);
  EXPECT_NEAR(wrong.chi2 - wrong.sigma.pull.squares, without.chi2, 0.01 * without.chi2);
  EXPECT_GT(wrong.chi2, 2.0 * without.chi2);  // as stated: the priors are in it
  EXPECT_FALSE(wrong.sigma.scaled);
  EXPECT_NEAR(wrong.sigma.a_posteriori, without.sigma.a_posteriori, 0.01);
  EXPECT_THAT(TrustOf(contradicted).verdict.words, Not(HasSubstr("times what the stated standard deviations predict")));
  EXPECT_FALSE(right.sigma.pull.is_set_aside);
  EXPECT_LT(right.sigma.pull.squares, 4.0);
  EXPECT_DOUBLE_EQ(right.sigma.a_posteriori, std::sqrt(right.chi2 / right.dof));
}

// So far off that the rows scatter by many times their sigma with it: how well the parameter is known the prior says
// all the same, so that it is estimated, and the prior named.
TEST(Trust, AWrongPriorThatBendsAllRowsIsNamed) {
  const std::string name = "geometry/p_x2";
  Experiment experiment;
  experiment.priors[name] = {1250.0, 0.1};  // mm: a length, where its correction is asked for
  const CalibrationProblem problem = Problem(Design(40), experiment);
  const Estimate estimate = EstimateJointly(problem);
  EXPECT_TRUE(estimate.parameters.coordinates()[estimate.parameters.FindCoordinate(name)].estimated());
  EXPECT_THAT(TrustOf(problem).verdict.reasons,
              ::testing::Contains(AllOf(HasSubstr("contradict the prior of " + name), HasSubstr("of the correction"))));
}

// What rows and prior say of each other does not go by how the intervals come about, nor by the weights of the rows.
TEST(Trust, APriorIsContradictedWhateverTheIntervalsGoBy) {
  const Kr270Design design = Design(40);
  const Estimate without = EstimateJointly(Problem(design));
  const std::string name = "geometry/p_x2";
  const int i = without.parameters.FindCoordinate(name);
  const auto conflicts_with = [&](const std::function<void(Experiment*)>& change) {
    Experiment experiment;
    experiment.priors[name] = {1e3 * (without.table[i].value + 8.0 * without.table[i].sigma), 0.001};
    change(&experiment);
    const CalibrationProblem problem = Problem(design, experiment);
    return PriorsAgainstRows(problem, EstimateJointly(problem));
  };
  const std::vector<PriorConflict> model = conflicts_with([](Experiment*) {});
  const std::vector<PriorConflict> sandwich =
      conflicts_with([](Experiment* experiment) { experiment->method.covariance = CovarianceKind::kSandwich; });
  const std::vector<PriorConflict> equal =
      conflicts_with([](Experiment* experiment) { experiment->method.weights = Weights::kEqual; });
  ASSERT_EQ(model.size(), 1U);
  EXPECT_NEAR(model[0].sigmas, 8.0, 0.5);
  for (const std::vector<PriorConflict>* other : {&sandwich, &equal}) {
    ASSERT_EQ(other->size(), 1U);
    EXPECT_NEAR((*other)[0].sigmas, model[0].sigmas, 0.1 * model[0].sigmas);
    EXPECT_NEAR((*other)[0].rows, model[0].rows, without.table[i].sigma);
  }
}

}  // namespace
}  // namespace sagitta::prior_conflict_test
