// What intervals promise on measured robots (../shared/data).
#include <gtest/gtest.h>

#include <random>

#include "estimator/agreement/agreement.h"
#include "tests/support/agreement.h"
#include "tests/support/real_data.h"

namespace sagitta::real_intervals_test {
namespace {

using test::Agreement;

class RealIntervalsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!test::HasRealData()) GTEST_SKIP() << "no ../shared/data next to the tree";
  }
};

TEST_F(RealIntervalsTest, PredictedValidationRmsOfAnotherRegion) {
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kColumn;
  experiment.validation.column = "group";
  experiment.validation.values = {"random"};
  for (const char* covariance : {"model", "sandwich"}) {
    experiment.method.covariance = *FindChoice<CovarianceKind>(covariance);
    const Estimate estimate = EstimateJointly(test::RealProblem("ur5_gts3800", {"measurements.csv"}, experiment));
    ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
    ASSERT_EQ(estimate.validation.observations, 20);
    // 20 poses carry 9 % themselves.
    EXPECT_NEAR(estimate.validation_predicted_rms / estimate.validation.rms, 1.0, 0.2) << covariance;
  }
}

TEST_F(RealIntervalsTest, PredictedValidationRmsOverTenFolds) {
  Experiment experiment;
  experiment.validation.kind = ValidationSpec::Kind::kColumn;
  experiment.validation.column = "group";
  experiment.validation.values = {"random"};
  CalibrationProblem problem = test::RealProblem("ur5_gts3800", {"measurements.csv"}, experiment);
  for (Observation& observation : problem.mutable_data()->observations)
    observation.excluded = problem.data().IsValidation(observation);
  std::vector<int> grid;
  for (size_t c = 0; c < problem.data().configurations.size(); ++c) {
    if (!problem.data().configurations[c].is_validation) grid.push_back(static_cast<int>(c));
    problem.mutable_data()->configurations[c].is_validation = false;
  }
  ASSERT_EQ(grid.size(), 1000u);
  std::mt19937_64 random(1);
  for (size_t i = grid.size(); i > 1; --i) std::swap(grid[i - 1], grid[random() % i]);
  double predicted = 0.0, observed = 0.0;
  for (int fold = 0; fold < 10; ++fold) {
    CalibrationProblem held_out = problem;
    for (size_t i = fold; i < grid.size(); i += 10)
      held_out.mutable_data()->configurations[grid[i]].is_validation = true;
    const Estimate estimate = EstimateJointly(held_out);
    ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
    ASSERT_EQ(estimate.validation.observations, 100);
    predicted += estimate.validation_predicted_rms * estimate.validation_predicted_rms;
    observed += estimate.validation.rms * estimate.validation.rms;
  }
  EXPECT_NEAR(std::sqrt(predicted / observed), 1.0, 0.05);
}

// Series D in short; the full figures are those of sagitta_agreement_study.
TEST_F(RealIntervalsTest, RandomHalvesAgreeWithinTheirIntervals) {
  Experiment experiment;
  experiment.method.covariance = CovarianceKind::kSandwich;
  const CalibrationProblem problem = test::RealProblem("ur10_leica", {"series_D.csv"}, experiment);
  const Agreement agreement = test::CompareRandomHalves(problem, 12, 1);
  ASSERT_EQ(agreement.failed, 0);
  ASSERT_GE(agreement.compared,
            96);  // as below; those that depend on what rests elsewhere in the other half do not count
  // Parameters of one split move together and all splits share the data: as if 12
  // splits of 8 independent differences, sqrt(0.95 * 0.05 / 96) = 2.2 %.
  EXPECT_NEAR(agreement.share(), 0.95, 4 * 0.022);
}

// Random halves share every model error and agree; regions do not, and the factor is reported.
TEST_F(RealIntervalsTest, WhatModelErrorAddsIsReported) {
  Experiment experiment;
  experiment.method.covariance = CovarianceKind::kSandwich;
  const CalibrationProblem problem = test::RealProblem("ur10_leica", {"series_D.csv"}, experiment);
  Estimate estimate = EstimateJointly(problem);
  ASSERT_TRUE(IsUsable(estimate.status)) << estimate.message;
  CheckAgreement(problem, {1, 12}, &estimate);
  const AgreementReport& report = estimate.agreement;
  ASSERT_EQ(report.kinds.size(), 2u);
  EXPECT_NEAR(report.kinds[0].share(), 0.95, 4 * 0.022);  // as above
  EXPECT_EQ(report.kinds[1].by, SplitBy::kRegion);
  EXPECT_LT(report.kinds[1].share(), 0.9);
  EXPECT_TRUE(report.disagrees);
  EXPECT_GT(report.inflation, 1.2);
}

}  // namespace
}  // namespace sagitta::real_intervals_test
