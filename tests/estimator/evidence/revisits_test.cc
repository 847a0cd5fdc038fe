// What visiting poses again is expected to decide, against densities written out.
#include "estimator/evidence/revisits.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "problems/simulation.h"
#include "tests/support/moved_kr270.h"

namespace sagitta::revisits_test {
namespace {

constexpr double kSigma = 1e-4;  // m, of the instrument

// Joints deviate by this much (rad) at every visit.
CalibrationProblem Deviating(double deviation) {
  Measurements data = test::DesignMeasurements(test::CampaignOf(25, 1, kSigma, 1));
  test::MeasureKr270(test::Kr270Truth(), kSigma, 1, &data);
  Experiment experiment;
  experiment.repeatability.angle.common = deviation;
  return test::Kr270ProblemOf(data, experiment);
}

// Whitened, by central differences of the independent kinematics.
Eigen::MatrixXd DeviationsOf(const Eigen::VectorXd& q, double deviation) {
  constexpr double kStep = 1e-5;
  const test::Kr270Truth truth;
  Eigen::MatrixXd moves(9, 6);
  for (int j = 0; j < 6; ++j) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(6, j);
    for (int m = 0; m < 3; ++m) {
      moves.block<3, 1>(3 * m, j) = (test::IndependentKr270Point(q + step, {}, truth.tools[m]) -
                                     test::IndependentKr270Point(q - step, {}, truth.tools[m])) /
                                    (2.0 * kStep);
    }
  }
  return moves * deviation / kSigma;
}

double LogDensity(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  return -0.5 * root.matrixL().solve(x).squaredNorm() - root.matrixLLT().diagonal().array().log().sum();
}

// Of the right one of both answers, over differences of two visits that are drawn from each.
double Expected(const CalibrationProblem& problem, const NextPoses& next, double deviation, int poses) {
  constexpr int kTrials = 1000;
  NormalNumbers normal(77);
  double sum = 0.0;
  for (int trial = 0; trial < 2 * kTrials; ++trial) {
    const bool deviates = trial < kTrials;
    double log_odds = 0.0;
    for (int k = 0; k < poses; ++k) {
      const Eigen::MatrixXd l = DeviationsOf(problem.data().configurations[next.poses[k].like].q, deviation);
      const Eigen::MatrixXd pose = 2.0 * Eigen::MatrixXd::Identity(9, 9), visit = pose + 2.0 * l * l.transpose();
      Eigen::VectorXd draw(9);
      for (double& x : draw) x = normal();
      const Eigen::VectorXd apart = (deviates ? visit : pose).llt().matrixL() * draw;
      log_odds += LogDensity(apart, visit) - LogDensity(apart, pose);
    }
    sum += 1.0 / (1.0 + std::exp(deviates ? -log_odds : log_odds));
  }
  return sum / (2 * kTrials);
}

TEST(Revisits, AreExpectedToDecideWhatDensitiesSay) {
  constexpr double kDeviation = 16e-6;  // about a third of the instrument's noise at the markers
  const CalibrationProblem problem = Deviating(kDeviation);
  const NextPoses next = ProposeRevisits(problem, problem.parameters);
  ASSERT_TRUE(next.again);
  ASSERT_EQ(next.poses.size(), 10u);
  for (const ProposedPose& pose : next.poses) {
    EXPECT_EQ(pose.q, problem.data().configurations[pose.like].q);
    EXPECT_FALSE(problem.data().configurations[pose.like].is_validation);
  }
  const double expected = Expected(problem, next, kDeviation, 10);
  ASSERT_GT(expected, 0.55);
  ASSERT_LT(expected, 0.95);
  EXPECT_NEAR(next.decides, expected, 4.0 * 0.5 / std::sqrt(2000.0));  // a probability scatters by less than a half
}

TEST(Revisits, WhereJointsHardlyDeviateNothingIsDecided) {
  const CalibrationProblem problem = Deviating(1e-9);
  const NextPoses next = ProposeRevisits(problem, problem.parameters);
  EXPECT_NEAR(next.decides, 0.5, 1e-3);
  EXPECT_EQ(next.needed, 0);
}

TEST(Revisits, WhereTheyDeviateByFarMoreThanTheInstrumentOnePoseDoes) {
  const CalibrationProblem problem = Deviating(3e-3);
  const NextPoses next = ProposeRevisits(problem, problem.parameters);
  EXPECT_GT(next.decides, 0.999);
  EXPECT_EQ(next.needed, 1);
}

}  // namespace
}  // namespace sagitta::revisits_test
