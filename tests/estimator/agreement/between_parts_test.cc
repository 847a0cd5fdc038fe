// Model error as a variance between parts: the moments find it, the table and predictions carry it.
#include "estimator/agreement/between_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <random>

#include "estimator/calibration/joint_estimator.h"
#include "estimator/sagitta.h"
#include "tests/support/judged.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::between_parts_test {
namespace {

using ::testing::HasSubstr;

// d = e_a - e_b + noise: the mean of 4000 splits has a standard error of sqrt(2 / 4000) of a variance, 2 %.
TEST(BetweenParts, MomentsFindTheCovarianceOfTheModelError) {
  Eigen::Matrix2d between, noise;
  between << 4.0, 1.5, 1.5, 1.0;
  noise << 2.0, -0.5, -0.5, 3.0;  // C_a + C_b
  const Eigen::Matrix2d root = Eigen::Matrix2d(2.0 * between + noise).llt().matrixL();
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr int kSplits = 4000;
  PartMoments moments(3);
  for (int s = 0; s < kSplits; ++s) {
    PartDifference difference;
    difference.columns = {0, 2};
    const double first = normal(random), second = normal(random);
    difference.value = root * Eigen::Vector2d(first, second);
    difference.covariance = noise;
    if (s % 2 == 1) difference.one_sided.assign(1, 1);
    moments.Add(difference);
  }
  const BetweenParts found = moments.Result(BaseTurns(ParameterSet(), {}));
  EXPECT_EQ(found.draws, Eigen::Vector3d(kSplits, 0, kSplits));
  // Of 4 (2 * 4 + 2): 10 / 2 * 2.2 % = 0.11; of 1 (2 * 1 + 3): 0.06. Four standard errors.
  EXPECT_NEAR(found.variance[0], 4.0, 0.45);
  EXPECT_EQ(found.variance[1], 0.0);
  EXPECT_NEAR(found.variance[2], 1.0, 0.23);
  EXPECT_NEAR(found.covariance(0, 0), 4.0, 0.45);
  EXPECT_NEAR(found.covariance(0, 2), 1.5, 0.28);
  EXPECT_EQ(found.covariance(0, 1), 0.0);
}

// Of two splits one has coordinate 1 on one side alone: the pair has the moment of the other split, not half of it.
TEST(BetweenParts, WhatOnePartAloneSeesCountsInTheSplitsOfBoth) {
  PartMoments moments(2);
  PartDifference both, one;
  both.columns = {0, 1};
  both.value = Eigen::Vector2d(3.0, 1.0);
  both.covariance = Eigen::Matrix2d::Identity();
  one.columns = {0};
  one.value = Eigen::VectorXd::Constant(1, 2.0);
  one.covariance = Eigen::MatrixXd::Identity(1, 1);
  one.one_sided = {1};
  moments.Add(both);
  moments.Add(one);
  const BetweenParts found = moments.Result(BaseTurns(ParameterSet(), {}));
  EXPECT_DOUBLE_EQ(found.covariance(0, 0), (8.0 + 3.0) / 4.0);
  EXPECT_DOUBLE_EQ(found.covariance(0, 1), 3.0 / 2.0);
  EXPECT_DOUBLE_EQ(found.covariance(1, 1), 0.0);
  EXPECT_EQ(found.draws, Eigen::Vector2d(2, 1));
}

// Base poses are compared along the base's axes and stated along the station's.
TEST(BetweenParts, TurnsBackToTheAxesOfTheStation) {
  const CalibrationProblem problem = test::Kr270Problem({}, {}, 1);
  std::vector<int> columns;
  for (const char* axis : {"x", "y", "z"})
    columns.push_back(problem.parameters.FindCoordinate(std::string("base/S1/") + axis));
  ParameterSet parameters = problem.parameters;
  parameters.SetBaseInStation(
      0, {Eigen::AngleAxisd(M_PI / 2, Vector3<double>::UnitZ()).toRotationMatrix(), Vector3<double>::Zero()});
  const BaseTurns turns(parameters, columns);
  Eigen::Matrix3d along_base = Eigen::Vector3d(1, 4, 9).asDiagonal();
  const Eigen::MatrixXd back = turns.TurnBack(along_base);
  EXPECT_NEAR((back - Eigen::MatrixXd(Eigen::Vector3d(4, 1, 9).asDiagonal())).norm(), 0.0, 1e-12);
  EXPECT_NEAR((turns.VariancesOf(back) - along_base.diagonal()).norm(), 0.0, 1e-12);
}

struct Judged {
  CalibrationProblem problem = test::Kr270Problem({}, {}, 1);
  Calibration calibration{problem, EstimateJointly(problem), {}};
  Estimate& estimate = calibration.estimate;

  // t^2 = ratio s^2 of every coordinate, uncorrelated as the noise is correlated: T = ratio C.
  void JudgeWith(double ratio, double draws) {
    BetweenParts between;
    between.covariance = ratio * estimate.covariance;
    between.variance = between.covariance.diagonal().cwiseMax(0.0);
    between.draws = Eigen::VectorXd::Constant(between.variance.size(), draws);
    between.reason = "parts of the data contradict each other";
    calibration.trust = test::JudgeTrust(problem, 1, &estimate, between);
  }
};

// By hand: s^2 = 1 known exactly, t^2 = 3 with 9 degrees of freedom. (1 + 3)^2 / (0 + 9 / 9) = 16 degrees of freedom,
// t_0.975(16) = 2.11991, normal 1.95996: 2 * 2.11991 / 1.95996 = 2.16322.
TEST(BetweenParts, WidensAnIntervalByWelchAndSatterthwaite) {
  Judged judged;
  const std::vector<ParameterEstimate> before = judged.estimate.table;
  judged.JudgeWith(3.0, 9.0);
  ASSERT_FALSE(judged.estimate.estimated.empty());
  for (const int i : judged.estimate.estimated) {
    const Interval &narrow = before[i].ci95, &wide = judged.estimate.table[i].ci95;
    EXPECT_NEAR((wide.high - wide.low) / (narrow.high - narrow.low), 2.16322, 1e-4) << before[i].name;
    EXPECT_NEAR(judged.calibration.trust.sigma[i] / before[i].sigma, 2.0, 1e-9);
    EXPECT_EQ(judged.calibration.trust.ci95_noise_only[i].low, narrow.low);
  }
  EXPECT_NEAR(judged.calibration.trust.model_error, 2.16322, 1e-4);
  EXPECT_THAT(judged.calibration.trust.model_error_words, HasSubstr("parts of the data contradict each other"));
}

TEST(BetweenParts, WidensNothingWherePartsAgree) {
  Judged judged;
  const std::vector<ParameterEstimate> before = judged.estimate.table;
  judged.calibration.trust = test::JudgeTrust(judged.problem, 1, &judged.estimate);
  for (size_t i = 0; i < before.size(); ++i) EXPECT_EQ(judged.estimate.table[i].ci95.high, before[i].ci95.high);
  EXPECT_EQ(judged.calibration.trust.model_error, 1.0);
  EXPECT_EQ(judged.calibration.trust.model_error_words, "");
}

// C + 3 C: predictions are twice as uncertain as by noise alone, as the table is.
TEST(BetweenParts, PredictionsCarryItLikeTheTable) {
  Judged judged;
  judged.calibration.trust = test::JudgeTrust(judged.problem, 1, &judged.estimate);
  const Eigen::MatrixXd noise = KnownFrom(judged.calibration).uncertainty.covariance;
  EXPECT_NEAR((noise - judged.estimate.covariance).norm() / noise.norm(), 0.0, 1e-9);
  Judged with;
  with.JudgeWith(3.0, 9.0);
  const KnownRobot known = KnownFrom(with.calibration);
  EXPECT_NEAR((known.uncertainty.covariance - 4.0 * noise).norm() / noise.norm(), 0.0, 1e-9);
  const Prediction narrow = Predict(KnownFrom(judged.calibration), judged.problem.data());
  const Prediction wide = Predict(known, judged.problem.data());
  for (const size_t k : {0u, 7u}) {
    EXPECT_NEAR(wide.covariances[k].mean().trace() / narrow.covariances[k].mean().trace(), 4.0, 1e-6);
  }
  EXPECT_THAT(WhatFiguresCarry(known), HasSubstr("carry the model error"));
}

// A moment estimate may say that a combination varies less than nothing: then noise alone is left.
TEST(BetweenParts, NothingBecomesMoreCertain) {
  Judged judged;
  const Eigen::MatrixXd noise = judged.estimate.covariance;
  BetweenParts between;
  between.covariance = -0.8 * noise;
  between.covariance(0, 0) = 5.0 * noise(0, 0);
  between.variance = between.covariance.diagonal().cwiseMax(0.0);
  between.draws = Eigen::VectorXd::Constant(between.variance.size(), 9.0);
  judged.calibration.trust = test::JudgeTrust(judged.problem, 1, &judged.estimate, between);
  const Eigen::MatrixXd wide = KnownFrom(judged.calibration).uncertainty.covariance;
  const Eigen::VectorXd size = noise.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd beyond = size.asDiagonal() * (wide - noise) * size.asDiagonal();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(beyond).eigenvalues()[0], -1e-8);
  EXPECT_GT(wide(0, 0), 5.0 * noise(0, 0));
}

}  // namespace
}  // namespace sagitta::between_parts_test
