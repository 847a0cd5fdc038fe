#include "estimator/baselines/canonical_rate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/baselines/two_step.h"
#include "estimator/calibration/joint_estimator.h"
#include "estimator/least_squares/ceres_problem.h"
#include "tests/support/kr270_experiment.h"

namespace sagitta::canonical_rate_test {
namespace {

TEST(CanonicalCorrelations, IsTheCosineBetweenTwoLines) {
  Eigen::MatrixXd a(3, 1), b(3, 1);
  a << 2e6, 0, 0;
  b << 3e-6, 4e-6, 0;
  const Eigen::VectorXd cosines = CanonicalCorrelations(a, b);
  ASSERT_EQ(cosines.size(), 1);
  EXPECT_NEAR(cosines[0], 0.6, 1e-15);
}

TEST(CanonicalCorrelations, FindsThePrincipalAnglesOfTwoPlanes) {
  // Planes that share x and are 30 degrees apart about it, each by an odd basis.
  Eigen::MatrixXd a(3, 2), b(3, 2);
  a << 1, 5, 0, 3, 0, 0;
  b << 2, -7, std::cos(M_PI / 6), 1e3 * std::cos(M_PI / 6), std::sin(M_PI / 6), 1e3 * std::sin(M_PI / 6);
  const Eigen::VectorXd cosines = CanonicalCorrelations(a, b);
  ASSERT_EQ(cosines.size(), 2);
  EXPECT_NEAR(cosines[0], 1.0, 1e-12);
  EXPECT_NEAR(cosines[1], std::cos(M_PI / 6), 1e-12);
}

TEST(CanonicalCorrelations, DependentColumnsSpanNoMore) {
  Eigen::MatrixXd a(3, 3), b(3, 1);
  a << 1, 2, -1, 0, 0, 0, 0, 0, 0;
  b << 1, 1, 0;
  const Eigen::VectorXd cosines = CanonicalCorrelations(a, b);
  ASSERT_EQ(cosines.size(), 1);
  EXPECT_NEAR(cosines[0], std::sqrt(0.5), 1e-15);
  EXPECT_EQ(CanonicalCorrelations(a, Eigen::MatrixXd(3, 0)).size(), 0);
}

// PUBLISHED section 2: random sets .81-.94, two tracker placements up to .953. The
// asymptotic ratio shows where the second correlation has died out, on most sets.
TEST(PredictTwoStepRate, IsTheMeasuredRateOfTheExactAlternation) {
  for (const int stations : {1, 2}) {
    for (const std::uint64_t seed : {1, 2, 4, 6}) {
      test::Kr270Design design;
      design.stations = stations;
      design.sigma = 1e-5;
      design.seed = seed;
      const CalibrationProblem problem = test::Kr270Problem(design, test::Kr270Truth(), seed);
      const Estimate joint = EstimateJointly(problem);
      ASSERT_EQ(joint.status, Status::kConverged);
      const ResidualSelection residuals = CalibrationResiduals(problem);
      const Linearization optimum =
          Linearize(problem, joint.parameters, residuals.observations, joint.estimated, residuals.noise);
      const double predicted = PredictTwoStepRate(optimum, joint.parameters);
      const TwoStepResult measured = EstimateInTwoSteps(problem);
      EXPECT_NEAR(measured.rate, predicted, 5e-4) << stations << " stations, seed " << seed;
      EXPECT_GT(predicted, 0.6);
      EXPECT_LT(predicted, 1.0);
    }
  }
}

}  // namespace
}  // namespace sagitta::canonical_rate_test
